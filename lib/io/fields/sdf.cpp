#include "core/large_memory.hpp"
#include "core/real_numbers.hpp"
#include "core/refuse.hpp"
#include "io/fields/field_files.hpp"
#include "tools/text.hpp"

#include <fmt/compile.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/parallel_pipeline.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <type_traits>

namespace clsdf {
namespace {

constexpr std::size_t longest_word = 4096;
constexpr std::size_t read_chunk = std::size_t{1} << 18;  // longer than any word of a valid file
constexpr std::string_view blanks = " \t\r\n";

bool is_blank(char letter) {
    return letter == ' ' || letter == '\t' || letter == '\r' || letter == '\n';
}

/// Reads the number at the begin of a text. Returns the position after it; null if there is no number.
template <class Number>
const char* parse_number(const char* begin, const char* end, Number& value) {
    auto [stop, error] = read_number(begin, end, value);
    if constexpr (std::is_same_v<Number, float>) {
        double wider = 0;
        if (error == std::errc::result_out_of_range && read_real(begin, end, wider).ec == std::errc()) {
            value = static_cast<float>(wider);
            error = {};
        }
    }
    return error == std::errc() ? stop : nullptr;
}

[[noreturn]] void fail_number(const InputFile& file, const char* what, std::string_view word) {
    file.fail(fmt::format("{}: {} is not a number", what, quoted(word, 80)));
}

/// A file that is too long for the memory, in pieces of whole words.
class WordPieces {
public:
    explicit WordPieces(InputFile& file) : file_(file) {}

    /// The next piece, which ends after a blank or at the end of the file. Empty at the end of the file.
    void next(std::string& text) {
        text.swap(rest_);
        rest_.clear();
        if (read_ == file_.size()) return;
        const std::size_t kept = text.size();
        text.resize(kept + static_cast<std::size_t>(std::min<std::uint64_t>(read_chunk, file_.size() - read_)));
        file_.read(read_, std::as_writable_bytes(std::span(text).subspan(kept)));
        read_ += text.size() - kept;
        if (read_ == file_.size()) return;
        const std::size_t end = text.find_last_of(blanks) + 1;
        if (text.size() - end > longest_word) file_.fail("words are longer than numbers; not an .sdf file");
        rest_.assign(text, end);
        text.resize(end);
    }

    /// Puts back the unread rest of the last piece.
    void put_back(std::string_view text) { rest_.insert(0, text); }

private:
    InputFile& file_;
    std::string rest_;
    std::uint64_t read_ = 0;  // bytes of the file
};

/// The numbers at the beginning of a file.
class Header {
public:
    Header(InputFile& file, WordPieces& pieces) : file_(file), pieces_(pieces) {}

    template <class Number>
    Number number(const char* what) {
        const std::string_view word = next();
        if (word.empty()) file_.fail(fmt::format("{} is missing; the file is truncated", what));
        Number value{};
        const char* const end = word.data() + word.size();
        if (parse_number(word.data(), end, value) != end) fail_number(file_, what, word);
        return value;
    }

    void end() { pieces_.put_back(rest_); }

private:
    /// Valid until the next call; empty at the end of the file.
    std::string_view next() {
        while (true) {
            rest_.remove_prefix(std::min(rest_.find_first_not_of(blanks), rest_.size()));
            if (!rest_.empty()) break;
            pieces_.next(text_);
            if (text_.empty()) return {};
            rest_ = text_;
        }
        const std::string_view word = rest_.substr(0, rest_.find_first_of(blanks));
        rest_.remove_prefix(word.size());
        return word;
    }

    InputFile& file_;
    WordPieces& pieces_;
    std::string text_;
    std::string_view rest_;
};

/// A piece of the file and its values.
struct Piece {
    std::string text;
    std::vector<float> values;
    std::string_view no_number;  ///< the word after the values, unless they end the piece

    void parse() {
        values.clear();
        no_number = {};
        const char* position = text.data();
        const char* const end = position + text.size();
        std::string_view last;  // word, with its blank
        while (true) {
            while (position != end && is_blank(*position)) ++position;
            if (position == end) return;
            // Beyond the band many values in succession are the same.
            if (!last.empty() && std::string_view(position, end).starts_with(last)) {
                values.push_back(values.back());
                position += last.size();
                continue;
            }
            float value = 0;
            const char* const stop = parse_number(position, end, value);
            if (stop == nullptr || (stop != end && !is_blank(*stop))) {
                no_number = {position, std::find_if(position, end, is_blank)};
                return;
            }
            values.push_back(value);
            last = stop == end ? std::string_view() : std::string_view(position, stop + 1);
            position = stop;
        }
    }
};

/// All cores parse pieces. The number of pieces in work is limited, and they end in order.
void read_values(InputFile& file, WordPieces& pieces, std::span<float> room) {
    std::array<Piece, 16> slots;
    std::size_t turn = 0;
    const auto next = [&](tbb::flow_control& flow) {
        Piece& piece = slots[turn++ % slots.size()];
        pieces.next(piece.text);
        if (piece.text.empty()) flow.stop();
        return &piece;
    };
    const auto parse = [](Piece* piece) {
        piece->parse();
        return piece;
    };
    std::size_t count = 0;
    bool ends_with_blank = true;
    const auto take = [&](const Piece* piece) {
        if (piece->values.size() > room.size() - count ||
            (count + piece->values.size() == room.size() && !piece->no_number.empty()))
            file.fail("more values follow than the sizes say; the header is wrong");
        if (!piece->no_number.empty()) fail_number(file, "a value", piece->no_number);
        std::ranges::copy(piece->values, room.begin() + static_cast<std::ptrdiff_t>(count));
        count += piece->values.size();
        ends_with_blank = is_blank(piece->text.back());
    };
    constexpr auto in_order = tbb::filter_mode::serial_in_order;
    tbb::task_group_context own(tbb::task_group_context::isolated);  // cancelled tasks of the caller do not end it
    tbb::parallel_pipeline(slots.size(),
                           tbb::make_filter<void, Piece*>(in_order, next) &
                               tbb::make_filter<Piece*, Piece*>(tbb::filter_mode::parallel, parse) &
                               tbb::make_filter<Piece*, void>(in_order, take),
                           own);
    if (count < room.size()) file.fail("a value is missing; the file is truncated");
    // A number that is cut off is a number too.
    if (!ends_with_blank) file.fail("no line end follows the last value; the file is truncated");
}

}  // namespace

Field read_sdf(const std::string& path, OutputSet) {
    InputFile file(path);
    WordPieces pieces(file);
    Header header(file, pieces);
    Field field;
    field.band = Band::full();
    field.sign = SignRule::automatic;
    for (std::int64_t& size : field.grid.size) size = header.number<std::int64_t>("the number of samples");
    for (double& origin : field.grid.origin) origin = header.number<double>("the origin");
    field.grid.spacing.fill(header.number<double>("the spacing"));
    header.end();
    field.grid.validate();
    // Each value has a letter and a blank.
    std::uint64_t room = file.size() / 2;
    for (const std::int64_t size : field.grid.size) room /= static_cast<std::uint64_t>(size);
    if (room == 0)
        file.fail(fmt::format("sizes: {} values do not fit the {} bytes of the file; it is truncated",
                              fmt::join(field.grid.size, " x "), file.size()));
    field.resize(Output::distance, field.grid.sample_count());
    read_values(file, pieces, field.distance());
    return field;
}

namespace {

constexpr std::size_t write_chunk = std::size_t{1} << 14;  // values whose text stays in a core's cache
constexpr std::size_t longest_line = 32;                   // a float's shortest text has 17 letters at most

/// The values as text, one on a line.
class Text {
public:
    void set(std::span<const float> values) {
        letters_.resize((values.size() + 1) * longest_line);
        char* end = letters_.data();
        std::array<char, longest_line> line{};
        std::size_t length = 0;
        for (std::size_t i = 0; i < values.size(); ++i) {
            // Beyond the band many values in succession are the same: their text is made once.
            if (i == 0 || std::bit_cast<std::uint32_t>(values[i]) != std::bit_cast<std::uint32_t>(values[i - 1]))
                length =
                    static_cast<std::size_t>(fmt::format_to(line.data(), FMT_COMPILE("{}\n"), values[i]) - line.data());
            std::memcpy(end, line.data(),
                        longest_line);  // a constant size is cheaper; the next line overwrites the rest
            end += length;
        }
        length_ = static_cast<std::size_t>(end - letters_.data());
    }

    std::string_view view() const { return {letters_.data(), length_}; }

private:
    UninitializedVector<char> letters_;
    std::size_t length_ = 0;
};

/// SDFGen's text (github.com/christopherbatty/SDFGen): the numbers of samples along x, y and z, the position of the
/// first sample, the spacing, and the values, one per line, x fastest.
class SdfWriter : public FormatWriter {
public:
    SdfWriter(const std::string& path, const FieldDescription& field) : file_(path) {
        const Grid& grid = field.grid;
        file_.write(fmt::format("{}\n{}\n{}\n", fmt::join(grid.size, " "), fmt::join(grid.position(0, 0, 0), " "),
                                grid.spacing[0]));
    }

    /// All cores format chunks while earlier chunks are written. There are as many chunks in work as text buffers, and
    /// they end in order: when a chunk begins, the previous text of its buffer has been written.
    void append(const FieldSlab& slab, std::int64_t) override {
        std::size_t begin = 0, turn = 0;
        const auto next = [&](tbb::flow_control& flow) {
            if (begin == slab.distance().size()) {
                flow.stop();
                return Chunk{};
            }
            const std::size_t count = std::min(write_chunk, slab.distance().size() - begin);
            const Chunk next_chunk{slab.distance().subspan(begin, count), &texts_[turn++ % texts_.size()]};
            begin += count;
            return next_chunk;
        };
        const auto make_text = [](const Chunk& values) {
            values.text->set(values.values);
            return values.text;
        };
        const auto write = [&](const Text* text) { file_.write(text->view()); };
        constexpr auto in_order = tbb::filter_mode::serial_in_order;
        tbb::task_group_context own(tbb::task_group_context::isolated);  // cancelled tasks of the caller do not end it
        tbb::parallel_pipeline(texts_.size(),
                               tbb::make_filter<void, Chunk>(in_order, next) &
                                   tbb::make_filter<Chunk, Text*>(tbb::filter_mode::parallel, make_text) &
                                   tbb::make_filter<Text*, void>(in_order, write),
                               own);
    }

    void finish() override { file_.commit(); }

private:
    struct Chunk {
        std::span<const float> values;
        Text* text = nullptr;
    };

    AtomicFile file_;
    std::array<Text, 32> texts_;
};

}  // namespace

std::unique_ptr<FormatWriter> sdf_writer(const std::string& path, const FieldDescription& field, OutputSet) {
    const Vec3& spacing = field.grid.spacing;
    if (spacing[1] != spacing[0] || spacing[2] != spacing[0])
        refuse_unsupported("{}: .sdf has one spacing for all axes, not {}; choose another format", path,
                           fmt::join(spacing, ", "));
    return std::make_unique<SdfWriter>(path, field);
}

}  // namespace clsdf
