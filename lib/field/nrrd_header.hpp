#pragma once

#include "field/numbers.hpp"
#include "field/raw_values.hpp"

#include <clsdf/box.hpp>

#include <map>
#include <string>
#include <string_view>

namespace clsdf {

/// The text before the values of an NRRD file (teem.sourceforge.net/nrrd/format.html).
class NrrdHeader {
public:
    /// Throws Error(unreadable_input) where the header is not one, or has no end.
    explicit NrrdHeader(InputFile& file);

    /// A field's text, or null. Names are compared without case and blanks, as "space origin" or "spaceorigin".
    const std::string* find(const std::string& field) const;
    /// Throws where the field is missing; `remedy` says what to do.
    const std::string& require(const std::string& field, const std::string& remedy) const;
    /// The text of a "key:=value" pair, or null.
    const std::string* find_pair(const std::string& key) const;

    /// The sizes of an array of so many dimensions.
    std::vector<std::int64_t> sizes(std::size_t dimensions) const;
    /// Type, byte order and place of the values, which must be raw and attached.
    RawValues values() const;

    /// "field 'sizes': '12 x' ..." with the name of the file before it.
    [[noreturn]] void fail(const std::string& field, const std::string& text, const std::string& what) const;

private:
    void parse_line(std::string_view line, std::size_t number);

    const InputFile& file_;
    std::map<std::string, std::string> fields_;
    std::map<std::string, std::string> pairs_;
    std::uint64_t data_offset_ = 0;
};

/// A value of a pair with backslashes and line ends as NRRD escapes them, and back.
std::string escaped(std::string_view text);
std::string unescaped(std::string_view text);

}  // namespace clsdf
