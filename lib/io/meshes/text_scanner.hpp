#pragma once

#include <clsdf/error.hpp>

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace clsdf {

/// Reads a text in memory word by word, and counts lines. Lines end with LF, CR LF, LF CR or CR.
class TextScanner {
public:
    struct Syntax {
        bool hash_comments = false;      ///< from # to the end of the line
        bool line_continuation = false;  ///< a backslash at the end of a line joins it to the next one
    };

    /// Neither the text nor the path is copied.
    TextScanner(std::string_view text, const std::string& path, Syntax syntax, std::size_t first_line = 1);

    /// Skips the rest of this line and any empty ones; false if no line is left. Before the first call the scanner
    /// stands before the first line.
    bool next_line();

    /// next_line() before the first line. Throws Error(unreadable_input) if no line has text.
    void first_line();

    /// The next word of this line; empty at its end.
    std::string_view word();

    /// Skips letters with which the next word of this line begins.
    void skip(std::size_t letters);

    /// The next word of the text, on this line or a later one; empty at the end of the text.
    std::string_view word_of_text();

    /// The next word of this line as a number; `what` describes it in messages. Infinity and NaN are numbers, also as
    /// older C libraries of Windows write them (1.#QNAN); a number too large for a double is infinite. Fortran's
    /// numbers are read, too: 1.0D+00, 1.0+120.
    double real(const char* what);
    /// The same of a word that has been taken.
    double real_in(std::string_view word, const char* what) const;
    std::int64_t integer(const char* what);

    bool at_end_of_line();

    /// Skips the end of the line if it comes next, and nothing after it. Returns false if another character comes next.
    bool end_line();

    /// The number of the line that the last word came from.
    std::size_t line() const { return line_; }

    /// The bytes after the last word.
    std::size_t remaining() const { return static_cast<std::size_t>(end_ - position_); }

    /// Throws Error(unreadable_input) with the file and the line.
    [[noreturn]] void fail(const std::string& reason) const;
    [[noreturn]] void fail(ErrorCode code, const std::string& reason) const;
    [[noreturn]] void fail_word(const char* what, std::string_view word) const;

private:
    void skip_blanks();
    void skip_line_end();
    std::size_t line_end_length() const;

    const char* position_;
    const char* end_;
    const std::string* path_;
    Syntax syntax_;
    std::size_t line_;
    bool before_first_line_ = true;
};

/// Whether the words agree but for upper and lower case; `lower` is in lower case.
bool equals_ignoring_case(std::string_view word, std::string_view lower);

}  // namespace clsdf
