#include "options.hpp"

#include "nearest_word.hpp"

#include "core/real_numbers.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>

using clsdf::Error;
using clsdf::ErrorCode;

namespace {

template <class Number>
std::optional<Number> parse_number(const std::string& text) {
    Number number{};
    const char* const end = text.data() + text.size();
    const auto [stop, error] = clsdf::read_number(text.data(), end, number);
    if (error != std::errc() || stop != end) return std::nullopt;
    return number;
}

// The checks return what is wrong with the text, or an empty text.

std::string check_text(const std::string& text) {
    return text.empty() ? "the value is missing" : "";
}

std::string check_file(const std::string& text) {
    if (text.empty()) return "the name of the file is missing";
    if (text != "-") return {};
    return "standard input and output are not supported, because a file's ending chooses its format; "
           "name a file (./- is one with that name)";
}

std::string check_number(const std::string& text) {
    const auto number = parse_number<double>(text);
    if (number && std::isfinite(*number)) return {};
    return fmt::format("a finite number, not '{}'", text);
}

std::string check_number_of_0_or_more(const std::string& text) {
    const auto number = parse_number<double>(text);
    if (number && std::isfinite(*number) && *number >= 0) return {};
    return fmt::format("a finite number, 0 or more, not '{}'", text);
}

std::string check_number_of_0_to_infinity(const std::string& text) {
    const auto number = parse_number<double>(text);
    if (number && *number >= 0) return {};
    return fmt::format("a number from 0 to inf, not '{}'", text);
}

std::string check_number_above_0(const std::string& text) {
    const auto number = parse_number<double>(text);
    if (number && std::isfinite(*number) && *number > 0) return {};
    return fmt::format("a finite number above 0, not '{}'", text);
}

auto check_word(const std::vector<std::string>& words) {
    return [=](const std::string& text) {
        if (std::find(words.begin(), words.end(), text) != words.end()) return std::string();
        return fmt::format("one of {}, not '{}'{}", fmt::join(words, ", "), text,
                           did_you_mean(nearest_word(text, words)));
    };
}

bool is_file(const std::string& placeholder) {
    return std::find(file_placeholders.begin(), file_placeholders.end(), placeholder) != file_placeholders.end();
}

}  // namespace

namespace {

/// "-o FILE", with the shortest name.
std::string usage_name(const CLI::Option& option) {
    const std::string name =
        option.get_snames().empty() ? "--" + option.get_lnames().front() : '-' + option.get_snames().front();
    return option.get_items_expected_max() > 0 ? name + ' ' + option.get_type_name() : name;
}

/// As of Option::usage().
std::string usage_of(const CLI::Option& option) {
    if (!option.get_option_text().empty()) return option.get_option_text();
    if (option.nonpositional()) return option.get_required() ? usage_name(option) : "";
    const std::string name = option.get_name(true) + (option.get_items_expected_max() > 1 ? "..." : "");
    return option.get_required() ? name : '[' + name + ']';
}

}  // namespace

Option& Option::takes(const std::string& placeholder) {
    option_->type_name(placeholder);
    if (is_file(placeholder)) option_->check(check_file);
    return *this;
}

Option& Option::takes_text(const std::string& placeholder) {
    option_->check(check_text);
    return takes(placeholder);
}

Option& Option::takes_whole_number(const std::string& placeholder, std::uint64_t least, std::uint64_t most) {
    option_->transform(CLI::Validator(
        [=](std::string& text) {
            const auto number = parse_number<std::uint64_t>(text);
            if (!number || *number < least || *number > most)
                return fmt::format("a whole number from {} to {}, not '{}'", least, most, text);
            // Without leading zeros, which CLI11 would take for the mark of octal digits.
            text = fmt::to_string(*number);
            return std::string();
        },
        ""));
    return takes(placeholder);
}

Option& Option::takes_number(const std::string& placeholder) {
    option_->check(check_number);
    return takes(placeholder);
}

Option& Option::takes_number_of_0_or_more(const std::string& placeholder) {
    option_->check(check_number_of_0_or_more);
    return takes(placeholder);
}

Option& Option::takes_number_of_0_to_infinity(const std::string& placeholder) {
    option_->check(check_number_of_0_to_infinity);
    return takes(placeholder);
}

Option& Option::takes_number_above_0(const std::string& placeholder) {
    option_->check(check_number_above_0);
    return takes(placeholder);
}

Option& Option::takes_one_of(const std::vector<std::string>& words) {
    option_->check(check_word(words));
    return takes(fmt::format("{}", fmt::join(words, "|")));
}

Option& Option::takes_some_of(const std::vector<std::string>& words) {
    option_->check(check_word(words));
    return separated_by_commas().takes(fmt::format("{},...", fmt::join(words, "|")));
}

Option& Option::separated_by_commas() {
    option_->delimiter(',');
    return *this;
}

Option& Option::required() {
    option_->required();
    return *this;
}

// CLI11 prints the option text in formats that are not used here.
Option& Option::in_usage(const std::string& text) {
    const std::string name = option_->get_positional() ? option_->get_name(true) : usage_name(*option_);
    option_->option_text(text.empty() ? name : text);
    return *this;
}

Option& Option::needs(const std::string& other) {
    option_->needs(other);
    return *this;
}

Option& Option::excludes(const std::string& other) {
    option_->excludes(other);
    return *this;
}

std::vector<std::string> Option::names() const {
    std::vector<std::string> names;
    for (const std::string& name : option_->get_snames()) names.push_back('-' + name);
    for (const std::string& name : option_->get_lnames()) names.push_back("--" + name);
    return names;
}

std::string Option::placeholder() const {
    return option_->get_items_expected_max() > 0 ? option_->get_type_name() : "";
}

std::string Option::takes() const {
    return option_->get_positional() ? option_->get_name(true) : placeholder();
}

std::string Option::text() const {
    return option_->get_description();
}

std::string Option::default_text() const {
    return option_->get_default_str();
}

std::string Option::group() const {
    return option_->get_group();
}

bool Option::repeats() const {
    return option_->get_positional() && option_->get_items_expected_max() > 1;
}

std::string Option::usage() const {
    return usage_of(*option_);
}

bool Option::is_required() const {
    return option_->get_required();
}

namespace {

// "--resolution N [256]": an option's type and its default, without the list of options that it excludes.
class HelpFormatter : public CLI::Formatter {
public:
    HelpFormatter() { column_width(28); }

    std::string make_option_opts(const CLI::Option* option) const override {
        std::string text;
        if (!option->get_type_name().empty() && !option->get_positional()) text += ' ' + option->get_type_name();
        if (!option->get_default_str().empty()) text += " [" + option->get_default_str() + ']';
        return text;
    }

    // With one empty line between groups, not two.
    std::string make_help(const CLI::App* parser, std::string name, CLI::AppFormatMode mode) const override {
        std::string text = CLI::Formatter::make_help(parser, std::move(name), mode);
        for (std::size_t at = text.find("\n\n\n"); at != std::string::npos; at = text.find("\n\n\n", at))
            text.erase(at, 1);
        return text;
    }

    // "Usage: clsdf query [OPTIONS] MESH... POINTS -o RESULT": what is required, in the order of the command line.
    std::string make_usage(const CLI::App* parser, std::string name) const override {
        std::string text = "Usage: " + name + " [OPTIONS]";
        for (const bool is_option : {false, true})
            for (const CLI::Option* const option : parser->get_options()) {
                const std::string usage = usage_of(*option);
                if (option->nonpositional() == is_option && !usage.empty()) text += ' ' + usage;
            }
        if (!parser->get_subcommands([](const CLI::App*) { return true; }).empty()) text += " SUBCOMMAND";
        return text + '\n';
    }

    // Without "exactly one of the following is required".
    std::string make_description(const CLI::App* parser) const override { return parser->get_description() + ".\n"; }
};

}  // namespace

Parser::Parser(const std::string& name, const std::string& text) : parser_(std::make_shared<CLI::App>(text, name)) {
    parser_->formatter(std::make_shared<HelpFormatter>());
    parser_->set_help_flag("-h,--help", "print this page");
}

Parser Parser::add_subcommand(const std::string& name, const std::string& text) {
    parser_->require_subcommand(1);
    return Parser(parser_->get_subcommand_ptr(parser_->add_subcommand(name, text)));
}

void Parser::add_version(const std::string& version, const std::string& text) {
    parser_->set_version_flag("--version", version, text);
}

template <class Value>
Option Parser::add(const std::string& names, Value& value, const std::string& text) {
    if constexpr (std::is_same_v<Value, bool>) {
        return Option(parser_->add_flag(names, value, text));
    } else {
        CLI::Option* const option = parser_->add_option(names, value, text);
        if constexpr (std::is_arithmetic_v<Value> || std::is_same_v<Value, std::string>)
            option->capture_default_str();
        else if (!option->get_positional())
            option->allow_extra_args(false);
        if (is_file(names)) option->check(check_file);
        return Option(option);
    }
}

template Option Parser::add(const std::string&, bool&, const std::string&);
template Option Parser::add(const std::string&, int&, const std::string&);
template Option Parser::add(const std::string&, std::int64_t&, const std::string&);
template Option Parser::add(const std::string&, std::uint64_t&, const std::string&);
template Option Parser::add(const std::string&, double&, const std::string&);
template Option Parser::add(const std::string&, std::string&, const std::string&);
template Option Parser::add(const std::string&, std::optional<double>&, const std::string&);
template Option Parser::add(const std::string&, std::optional<std::uint32_t>&, const std::string&);
template Option Parser::add(const std::string&, std::optional<std::int64_t>&, const std::string&);
template Option Parser::add(const std::string&, std::optional<std::uint64_t>&, const std::string&);
template Option Parser::add(const std::string&, std::vector<std::uint32_t>&, const std::string&);
template Option Parser::add(const std::string&, std::vector<std::string>&, const std::string&);

void Parser::begin_group(const std::string& title) {
    parser_->option_defaults()->group(title);
}

void Parser::set_footer(const std::string& footer) {
    parser_->footer(footer);
}

void Parser::hide() {
    parser_->group("");
}

namespace {

/// CLI11 would take the next argument as the value of "--name=".
void refuse_missing_values(std::span<const char* const> arguments) {
    for (const std::string_view argument : arguments) {
        if (argument == "--") return;
        if (argument.starts_with("--") && argument.find('=') == argument.size() - 1)
            throw Error(ErrorCode::invalid_argument,
                        fmt::format("{}: the value is missing", argument.substr(0, argument.size() - 1)));
    }
}

std::vector<std::string> known_words(const Parser& parser) {
    std::vector<std::string> words;
    for (const Parser& subcommand : parser.subcommands()) words.push_back(subcommand.name());
    for (const Option& option : parser.options())
        for (const std::string& name : option.names())
            if (name.starts_with("--")) words.push_back(name);
    return words;
}

std::string explain(const CLI::ParseError& error, const CLI::App& parser) {
    const std::string text = error.what();
    // "--resolution: 1 required N missing"
    if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr && text.ends_with(" missing"))
        return text.substr(0, text.find(':')) + ": the value is missing";
    // "--output is required"
    if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr)
        for (const CLI::Option* const option : parser.get_options())
            if (text == option->get_name() + " is required")
                return fmt::format("{} ({})", text, option->get_description());
    return text;
}

}  // namespace

std::optional<std::string> Parser::parse(int argument_count, const char* const* arguments) {
    refuse_missing_values(std::span(arguments, static_cast<std::size_t>(argument_count)).subspan(1));
    const auto chosen = [&] {
        const auto subcommands = parser_->get_subcommands();
        return subcommands.empty() ? *this : Parser(parser_->get_subcommand_ptr(subcommands.front()));
    };
    const auto usage_error = [&](const std::string& message) {
        return Error(ErrorCode::invalid_argument,
                     fmt::format("{}\n\"{} --help\" lists the options.", message, chosen().full_name()));
    };
    try {
        parser_->parse(argument_count, arguments);
    } catch (const CLI::CallForVersion& request) {
        return std::string(request.what()) + '\n';
    } catch (const CLI::CallForHelp&) {
        return chosen().help();
    } catch (const CLI::ParseError& error) {
        // The first word that no option and no subcommand took.
        const std::vector<std::string> unknown = chosen().parser_->remaining();
        if (unknown.empty()) throw usage_error(explain(error, *chosen().parser_));
        const std::string word = unknown.front().substr(0, unknown.front().find('='));
        const char* const kind = word.starts_with('-')                ? "option"
                                 : parser_->get_subcommands().empty() ? "subcommand"
                                                                      : "argument";
        throw usage_error(
            fmt::format("unknown {} {}{}", kind, word, did_you_mean(nearest_word(word, known_words(chosen())))));
    }
    return std::nullopt;
}

bool Parser::is_chosen() const {
    return parser_->parsed();
}

bool Parser::has(const std::string& option) const {
    return parser_->count(option) > 0;
}

std::string Parser::full_name() const {
    const CLI::App* const program = parser_->get_parent();
    return program == nullptr ? name() : program->get_name() + ' ' + name();
}

std::string Parser::help() const {
    return parser_->get_formatter()->make_help(parser_.get(), full_name(), CLI::AppFormatMode::Normal);
}

std::string Parser::name() const {
    return parser_->get_name();
}

std::string Parser::text() const {
    return parser_->get_description();
}

std::string Parser::footer() const {
    return parser_->get_footer();
}

std::vector<Option> Parser::options() const {
    std::vector<Option> options;
    for (CLI::Option* const option : parser_->get_options()) options.emplace_back(option);
    return options;
}

std::vector<Parser> Parser::subcommands() const {
    std::vector<Parser> subcommands;
    for (CLI::App* const subcommand : parser_->get_subcommands([](const CLI::App*) { return true; }))
        if (!subcommand->get_group().empty()) subcommands.push_back(Parser(parser_->get_subcommand_ptr(subcommand)));
    return subcommands;
}
