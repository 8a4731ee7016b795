#include "io/meshes/mesh_files.hpp"
#include "tools/text.hpp"

#include <clsdf/error.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>

/// Files that are not what their ending says.
namespace clsdf {

bool is_text(std::string_view bytes) {
    return std::ranges::none_of(bytes, [](char c) {
        const auto byte = static_cast<unsigned char>(c);
        return byte == 0x7F || byte == 0xFF || (byte < 0x20 && (byte < '\t' || byte > '\r'));
    });
}

namespace {

using namespace std::string_view_literals;

constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

std::string_view head_of(const FileContent& file) {
    std::string_view head = file.text().substr(0, telling_bytes);
    if (head.starts_with(byte_order_mark)) head.remove_prefix(byte_order_mark.size());
    return head;
}

/// The text from its first line that is not blank on.
std::string_view without_blanks(std::string_view text) {
    return text.substr(std::min(text.find_first_not_of(" \t\v\f\r\n"), text.size()));
}

std::string_view first_line(std::string_view text) {
    return text.substr(0, text.find_first_of("\r\n"));
}

bool starts_with_ignoring_case(std::string_view text, std::string_view lower) {
    return equals_ignoring_case(text.substr(0, lower.size()), lower);
}

/// The first bytes of files that hold no mesh as they are, and what to say of such a file.
struct Signature {
    std::string_view bytes;
    const char* what;
};
constexpr std::array packed_signatures{
    Signature{"\x1F\x8B"sv, "gzip; unpack it first, as gunzip does"},
    Signature{
        "PK\x03\x04"sv,
        "zip; unpack it first, or, if it is a package of a program, such as .3mf, export the mesh as .stl or .ply "
        "from there"},
    Signature{"BZh"sv, "bzip2; unpack it first, as bunzip2 does"},
    Signature{"\xFD\x37zXZ"sv, "xz; unpack it first, as unxz does"},
    Signature{"\x28\xB5\x2F\xFD"sv, "zstd; unpack it first, as unzstd does"},
    Signature{"7z\xBC\xAF\x27\x1C"sv, "7-Zip; unpack it first"},
    Signature{"Rar!\x1A"sv, "RAR; unpack it first"},
};
constexpr std::array other_signatures{
    Signature{"glTF"sv, "a binary glTF file"},
    Signature{"Kaydara FBX Binary"sv, "an FBX file"},
    Signature{"ISO-10303-21"sv, "a STEP file"},
    Signature{"# vtk DataFile"sv, "a file of VTK"},
    Signature{"<VTKFile"sv, "an XML file of VTK"},
    Signature{"$MeshFormat"sv, "a file of Gmsh"},
    Signature{"\x89HDF\r\n\x1A\n"sv, "an HDF5 file"},
    Signature{"MeshVersionFormatted"sv, "a file of Medit"},
    Signature{"%PDF-"sv, "a PDF file"},
    Signature{"\x89PNG\r\n"sv, "a picture"},
};

/// The byte order, if the text is in UTF-16 or UTF-32.
std::optional<std::string> wide_encoding(std::string_view text) {
    if (text.starts_with("\xFF\xFE\0\0"sv) || text.starts_with("\0\0\xFE\xFF"sv)) return "UTF-32";
    if (text.starts_with("\xFF\xFE"sv) || text.starts_with("\xFE\xFF"sv)) return "UTF-16";
    // Without a mark: every other byte is zero, and the others are letters.
    const std::string_view begin = text.substr(0, std::min<std::size_t>(text.size() / 2 * 2, 32));
    if (begin.size() < 8) return {};
    for (const std::size_t zero : {1U, 0U}) {
        bool is_wide = true;
        for (std::size_t i = 0; i < begin.size(); ++i)
            is_wide = is_wide && (i % 2 == zero ? begin[i] == '\0' : begin[i] != '\0' && is_text(begin.substr(i, 1)));
        if (is_wide) return "UTF-16";
    }
    return {};
}

/// The number of bytes that a pointer of Git LFS states, in words; empty if there is none.
std::string size_in_pointer(std::string_view head) {
    constexpr std::string_view key = "\nsize ";
    const std::size_t at = head.find(key);
    if (at == std::string_view::npos) return {};
    const std::string_view rest = head.substr(at + key.size());
    const std::string_view digits = rest.substr(0, rest.find_first_not_of("0123456789"));
    if (digits.empty()) return {};
    return fmt::format(", which has {} byte{}", digits.substr(0, 20), digits == "1" ? "" : "s");
}

[[noreturn]] void refuse(const FileContent& file, const std::string& reason) {
    throw Error(ErrorCode::unreadable_input, fmt::format("{}: {}", file.path(), reason));
}

/// "; it begins with 'solid part'"
std::string begin_in_words(const FileContent& file) {
    const std::string begin = quoted_begin(file);
    return begin.empty() ? begin : fmt::format("; it begins with {}", begin);
}

bool is_ply(std::string_view head) {
    if (first_line(head) != "ply" && !head.starts_with("ply ")) return false;
    const std::string_view second = without_blanks(head.substr(3));
    return second.starts_with("format ") || second.starts_with("comment") || second.starts_with("obj_info");
}

bool is_off(std::string_view head) {
    std::string_view word = head.substr(0, head.find_first_of(" \t\r\n#"));
    for (const std::string_view prefix : {"st"sv, "c"sv, "n"sv, "4"sv, "n"sv})
        if (word.size() > 3 && starts_with_ignoring_case(word, prefix)) word.remove_prefix(prefix.size());
    return equals_ignoring_case(word, "off");
}

bool is_text_stl(std::string_view head) {
    if (!starts_with_ignoring_case(head, "solid")) return false;
    const std::string_view rest = head.substr(first_line(head).size());
    return starts_with_ignoring_case(without_blanks(rest), "facet");
}

/// Whether the first lines are those of OBJ, a vertex among them.
bool is_obj(std::string_view head) {
    while (!head.empty()) {
        const std::string_view line = first_line(head);
        head = without_blanks(head.substr(line.size()));
        if (line.starts_with('#')) continue;
        const std::string_view word = line.substr(0, line.find_first_of(" \t"));
        if (word == "v") {
            const std::string_view number = without_blanks(line.substr(1));
            return !number.empty() && number.find_first_of("+-.0123456789") == 0;
        }
        constexpr std::array keywords{"vn"sv, "vt"sv, "o"sv, "g"sv, "s"sv, "usemtl"sv, "mtllib"sv};
        if (std::ranges::find(keywords, word) == keywords.end()) return false;
    }
    return false;
}

std::optional<MeshFormat> format_of_content(const FileContent& file) {
    if (has_size_of_binary_stl(file) && file.size() > 84) return MeshFormat::stl;
    const std::string_view head = without_blanks(head_of(file));
    if (is_ply(head)) return MeshFormat::ply;
    if (!is_text(head)) return {};
    if (is_text_stl(head)) return MeshFormat::stl;
    std::string_view after_comments = head;
    while (after_comments.starts_with('#'))
        after_comments = without_blanks(after_comments.substr(first_line(after_comments).size()));
    if (is_off(after_comments)) return MeshFormat::off;
    if (is_obj(head)) return MeshFormat::obj;
    return {};
}

const char* name_of(MeshFormat format) {
    switch (format) {
        case MeshFormat::off:
            return "an OFF file";
        case MeshFormat::obj:
            return "an OBJ file";
        case MeshFormat::stl:
            return "an STL file";
        case MeshFormat::ply:
            break;
    }
    return "a PLY file";
}

}  // namespace

std::string quoted_begin(const FileContent& file) {
    const std::string_view head = head_of(file).substr(0, 512);
    std::string_view line = first_line(without_blanks(head));
    line = line.substr(0, line.find_last_not_of(" \t") + 1);
    return line.empty() || !is_text(head) ? std::string() : quoted(line);
}

void refuse_other_content(const FileContent& file) {
    const std::string_view head = without_blanks(head_of(file));
    if (head.starts_with("version https://git-lfs.github.com/spec/") ||
        head.starts_with("version https://hawser.github.com/spec/"))
        refuse(file, fmt::format("this is a pointer of Git LFS, not the file itself{}; get that with 'git lfs pull'{}",
                                 size_in_pointer(head), begin_in_words(file)));
    for (const std::string_view begin : {"<!doctype html"sv, "<html"sv, "<head"sv, "<body"sv, "<title"sv})
        if (starts_with_ignoring_case(head, begin))
            refuse(file,
                   fmt::format("this is an HTML page, as a server sends for a file that it does not have or wants a "
                               "login for; download the file itself{}",
                               begin_in_words(file)));
    if (const auto encoding = wide_encoding(file.text()))
        refuse(file,
               fmt::format("this is text in {}, as PowerShell's '>' writes it; save it as UTF-8 or ASCII", *encoding));
    for (const Signature& signature : packed_signatures)
        if (file.text().starts_with(signature.bytes))
            refuse(file, fmt::format("this file is compressed by {}", signature.what));
}

void refuse_other_content(const FileContent& file, MeshFormat format) {
    // The header of a binary STL file may hold anything.
    if (format == MeshFormat::stl && has_size_of_binary_stl(file)) return;
    refuse_other_content(file);
    const std::string_view head = without_blanks(head_of(file));
    for (const Signature& signature : other_signatures)
        if (head.starts_with(signature.bytes) || file.text().starts_with(signature.bytes))
            refuse(file, fmt::format("this is {}, not {}; convert it to .off, .obj, .stl or .ply{}", signature.what,
                                     name_of(format), begin_in_words(file)));
    const std::optional<MeshFormat> found = format_of_content(file);
    if (!found || *found == format) return;
    if (*found == MeshFormat::stl && quoted_begin(file).empty())
        refuse(file, fmt::format("this is a binary STL file, by its size; give it the ending .stl"));
    refuse(file, fmt::format("it begins as {}, with {}; give it the ending {}", name_of(*found), quoted_begin(file),
                             ending_of(*found)));
}

}  // namespace clsdf
