#pragma once

#include <fmt/format.h>

#include <string_view>

/// Opens each closed standard stream on /dev/null: input for writing, output and error for reading. Otherwise the next
/// file would get the stream's number and receive the printed text. Writing a result to a closed output still fails.
/// Call it before anything opens a file.
void open_closed_streams();

/// From now on a write into a pipe without a reader, or beyond the limit on a file's size, fails with EPIPE or EFBIG;
/// SIGPIPE and SIGXFSZ would end the process in the middle of a file.
void let_writes_fail();

/// Human text, on standard error. Text that cannot be written is dropped: a full disk changes no exit
/// status.
void write_to_standard_error(std::string_view text) noexcept;

/// The same, formatted. All output but results is printed by it.
template <class... Values>
void print_text(fmt::format_string<const Values&...> format, const Values&... values) noexcept {
    try {
        write_to_standard_error(fmt::format(format, values...));
    } catch (const std::exception&) {
        // Out of memory: the text is dropped.
    }
}
