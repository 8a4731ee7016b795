#include "documents.hpp"

#include "commit.hpp"
#include "report.hpp"

#include <clsdf/version.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <sstream>

namespace {

// A hyphen that is typed is a minus sign to roff, and a dot or an apostrophe that begins a line a command.
std::string escaped(const std::string& text) {
    std::string result;
    for (const char letter : text) {
        switch (letter) {
            case '\\':
                result += "\\e";
                break;
            case '-':
                result += "\\-";
                break;
            case '\'':
                result += "\\(aq";
                break;
            case '^':
                result += "\\(ha";
                break;
            case '~':
                result += "\\(ti";
                break;
            case '`':
                result += "\\(ga";
                break;
            default:
                result += letter;
        }
    }
    return result.starts_with('.') ? "\\&" + result : result;
}

std::string upper_case(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(), [](char letter) {
        return letter >= 'a' && letter <= 'z' ? static_cast<char>(letter - 32) : letter;
    });
    return text;
}

std::string bold(const std::string& text) {
    return "\\fB" + escaped(text) + "\\fR";
}

// Literal text is bold, placeholders are italic.
std::string value(const OptionDescription& option) {
    if (!option.words.empty() && option.takes.find('|') != std::string::npos) return bold(option.takes);
    return "\\fI" + escaped(option.takes) + "\\fR";
}

// "[MESH...]": the word alone is italic.
std::string italic_words(const std::string& usage) {
    const auto is_letter = [](char letter) { return letter >= 'A' && letter <= 'Z'; };
    const auto begin = std::find_if(usage.begin(), usage.end(), is_letter);
    const auto end = std::find_if_not(begin, usage.end(), is_letter);
    return std::string(usage.begin(), begin) + "\\fI" + std::string(begin, end) + "\\fR" +
           std::string(end, usage.end());
}

std::string sentence(std::string text) {
    if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 32);
    return text + '.';
}

class PageWriter {
public:
    PageWriter(const std::string& name, const std::string& text) {
        line(".TH {} 1 {} \"clsdf {}\" \"clsdf manual\"", upper_case(escaped(name)), CLSDF_DATE, clsdf::version());
        section("NAME");
        std::string small = text;
        if (small.size() > 1 && small[1] >= 'a' && small[1] <= 'z' && small[0] >= 'A' && small[0] <= 'Z')
            small[0] = static_cast<char>(small[0] + 32);
        line("{} \\- {}", escaped(name), escaped(small));
    }

    template <class... Values>
    void line(fmt::format_string<const Values&...> format, const Values&... values) {
        fmt::format_to(std::back_inserter(text_), format, values...);
        text_ += '\n';
    }

    void section(const std::string& title) { line(".SH {}", upper_case(title)); }

    void paragraphs(const std::vector<std::string>& paragraphs) {
        for (const std::string& paragraph : paragraphs) {
            if (&paragraph != &paragraphs.front()) line(".PP");
            words(paragraph);
        }
    }

    void item(const std::string& tag, const std::string& text) {
        line(".TP\n{}", tag);
        words(text);
    }

    // No line longer than 80 letters, and each with its own first letter escaped.
    void words(const std::string& text) {
        std::istringstream stream(text);
        std::string filled;
        for (std::string word; stream >> word;) {
            if (!filled.empty() && escaped(filled).size() + 1 + escaped(word).size() > 79) {
                line("{}", escaped(filled));
                filled.clear();
            }
            filled += (filled.empty() ? "" : " ") + word;
        }
        line("{}", escaped(filled));
    }

    void examples(const std::vector<std::string>& lines) {
        if (lines.empty()) return;
        section("examples");
        line(".nf\n.RS");
        for (const std::string& example : lines) line("{}", escaped(example));
        line(".RE\n.fi");
    }

    void options(const std::vector<OptionGroup>& groups) {
        for (const OptionGroup& group : groups) {
            section(group.title == "Options" ? "options" : group.title + " options");
            for (const OptionDescription& option : group.options) {
                std::string tag;
                for (const std::string& name : option.names) tag += (tag.empty() ? "" : ", ") + bold(name);
                if (!option.is_flag()) tag += ' ' + value(option);
                item(tag, sentence(option.text) +
                              (option.default_text.empty() ? "" : " The default is " + option.default_text + '.'));
            }
        }
    }

    void exit_status() {
        section("exit status");
        for (const auto& [status, meaning] : exit_status_meanings())
            item(bold(std::to_string(static_cast<int>(status))), sentence(meaning));
    }

    const std::string& text() const { return text_; }

private:
    std::string text_ = ".\\\" Made from the options of the program by the build.\n";
};

std::string page_of(const SubcommandDescription& subcommand) {
    const std::string name = "clsdf-" + subcommand.name;
    PageWriter page(name, subcommand.text);
    page.section("synopsis");
    std::string synopsis = bold("clsdf " + subcommand.name) + " [\\fIOPTION\\fR ...]";
    for (const OptionDescription& argument : subcommand.arguments) synopsis += ' ' + italic_words(argument.usage);
    for (const OptionDescription& option : subcommand.options())
        if (const std::size_t end = option.usage.find(' '); !option.usage.empty())
            synopsis += ' ' + bold(option.usage.substr(0, end)) + ' ' + italic_words(option.usage.substr(end + 1));
    page.line("{}", synopsis);
    page.section("description");
    page.words(subcommand.text + '.');
    if (!subcommand.explanation.empty()) page.line(".PP");
    page.paragraphs(subcommand.explanation);
    if (!subcommand.arguments.empty()) page.section("arguments");
    for (const OptionDescription& argument : subcommand.arguments) page.item(value(argument), sentence(argument.text));
    page.options(subcommand.groups);
    page.examples(subcommand.examples);
    page.exit_status();
    page.section("see also");
    page.line(".BR clsdf (1)");
    return page.text();
}

std::string page_of(const ProgramDescription& description) {
    const SubcommandDescription& program = description.program;
    PageWriter page("clsdf", program.text);
    page.section("synopsis");
    page.line("{} \\fISUBCOMMAND\\fR [\\fIOPTION\\fR ...] [\\fIARGUMENT\\fR ...]", bold("clsdf"));
    page.section("description");
    page.words(program.text + '.');
    page.line(".PP");
    page.paragraphs(program.explanation);
    page.section("subcommands");
    for (const SubcommandDescription& subcommand : description.subcommands)
        page.item(bold(subcommand.name), sentence(subcommand.text));
    page.options(program.groups);
    page.examples(program.examples);
    page.section("environment");
    page.item(bold("CLSDF_DEVICE"),
              "The device that computes without --device: an index of the list that clsdf devices prints, or "
              "a part of a name in it.");
    page.item(bold("CLSDF_CACHE_DIR"),
              "The folder of records of tested programs and, but for PoCL, which keeps them itself, of compiled "
              "programs, so that only the first start is slow; if it is set and empty, nothing is kept. Without it, "
              "the folder clsdf in $XDG_CACHE_HOME, or in ~/.cache.");
    page.item(bold("OCL_ICD_VENDORS"),
              "The folder in which the loader of OpenCL looks for drivers, instead of its own.");
    page.exit_status();
    page.section("see also");
    for (const SubcommandDescription& subcommand : description.subcommands)
        page.line(".BR {} (1){}", escaped("clsdf-" + subcommand.name),
                  &subcommand == &description.subcommands.back() ? "" : ",");
    return page.text();
}

}  // namespace

std::vector<ManualPage> manual_pages(const ProgramDescription& description) {
    std::vector<ManualPage> pages{{"clsdf.1", page_of(description)}};
    for (const SubcommandDescription& subcommand : description.subcommands)
        pages.push_back({"clsdf-" + subcommand.name + ".1", page_of(subcommand)});
    return pages;
}
