#include "field/formats.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <iterator>
#include <type_traits>

namespace clsdf {
namespace {

constexpr std::size_t chunk = std::size_t{1} << 20;
constexpr std::size_t longest_word = 4096;

/// SDFGen's text (github.com/christopherbatty/SDFGen): the samples along x, y and z, the position of the first one, the
/// one spacing, and the values, one on a line, x fastest.
class SdfWriter : public FormatWriter {
public:
    SdfWriter(const std::string& path, const FieldDescription& field) : file_(path) {
        const Grid& grid = field.grid;
        file_.write(fmt::format("{}\n{}\n{}\n", fmt::join(grid.size, " "), fmt::join(grid.position(0, 0, 0), " "),
                                grid.spacing[0]));
    }

    /// Some chunks at a time are made on all cores, and written in their order.
    void append(const FieldSlab& slab, std::int64_t) override {
        const std::span<const float> values = slab.distance;
        for (std::size_t begin = 0; begin < values.size(); begin += texts_.size() * values_of_chunk) {
            tbb::parallel_for(std::size_t{0}, texts_.size(), [&](std::size_t i) {
                const std::size_t first = std::min(begin + i * values_of_chunk, values.size());
                set_text(values.subspan(first, std::min(values_of_chunk, values.size() - first)), texts_[i]);
            });
            for (const fmt::memory_buffer& text : texts_) file_.write(std::string_view(text.data(), text.size()));
        }
    }

    void finish() override { file_.commit(); }

private:
    static constexpr std::size_t values_of_chunk = std::size_t{1} << 16;

    /// Beyond the band many values in succession are the same: their text is made once.
    static void set_text(std::span<const float> values, fmt::memory_buffer& text) {
        text.clear();
        fmt::memory_buffer line;
        for (std::size_t i = 0; i < values.size(); ++i) {
            if (i == 0 || std::bit_cast<std::uint32_t>(values[i]) != std::bit_cast<std::uint32_t>(values[i - 1])) {
                line.clear();
                fmt::format_to(std::back_inserter(line), "{}\n", values[i]);
            }
            text.append(line.data(), line.data() + line.size());
        }
    }

    AtomicFile file_;
    std::array<fmt::memory_buffer, 16> texts_;
};

/// The words of a file that is too long for the memory.
class Words {
public:
    explicit Words(InputFile& file) : file_(file) {}

    /// Valid until the next call; empty at the end.
    std::string_view next() {
        while (true) {
            const std::size_t begin = std::min(text_.find_first_not_of(blanks, position_), text_.size());
            const std::size_t end = text_.find_first_of(blanks, begin);
            const bool is_whole = begin < text_.size() && (end != std::string::npos || read_ == file_.size());
            if (is_whole || read_ == file_.size()) {
                const std::string_view word = std::string_view(text_).substr(begin, end - begin);
                position_ = begin + word.size();
                return word;
            }
            if (text_.size() - begin > longest_word) file_.fail("words are longer than numbers; not an .sdf file");
            text_.erase(0, begin);
            position_ = 0;
            const std::size_t kept = text_.size();
            text_.resize(kept + static_cast<std::size_t>(std::min<std::uint64_t>(chunk, file_.size() - read_)));
            file_.read(read_, std::as_writable_bytes(std::span(text_).subspan(kept)));
            read_ += text_.size() - kept;
        }
    }

    template <class Number>
    Number number(const char* what) {
        const std::string_view word = next();
        if (word.empty()) file_.fail(fmt::format("{} is missing; the file is truncated", what));
        Number value{};
        const char* const end = word.data() + word.size();
        auto [stop, error] = std::from_chars(word.data(), end, value);
        if constexpr (std::is_same_v<Number, float>) {
            double wider = 0;
            if (error == std::errc::result_out_of_range && std::from_chars(word.data(), end, wider).ec == std::errc()) {
                value = static_cast<float>(wider);
                error = {};
            }
        }
        if (error != std::errc() || stop != end)
            file_.fail(fmt::format("{}: '{}' is not a number", what, word.substr(0, 80)));
        return value;
    }

    /// The last word, with a blank behind it: a number that is cut off is a number too.
    void end() {
        if (position_ == text_.size()) file_.fail("no line end follows the last value; the file is truncated");
        if (!next().empty()) file_.fail("more values follow than the sizes say; the header is wrong");
    }

private:
    static constexpr const char* blanks = " \t\r\n";

    InputFile& file_;
    std::string text_;
    std::size_t position_ = 0;
    std::uint64_t read_ = 0;  // bytes of the file
};

}  // namespace

std::unique_ptr<FormatWriter> sdf_writer(const std::string& path, const FieldDescription& field, const Outputs&) {
    const Vec3& spacing = field.grid.spacing;
    if (spacing[1] != spacing[0] || spacing[2] != spacing[0])
        throw Error(ErrorCode::unsupported,
                    fmt::format("{}: .sdf has one spacing for all axes, not {}; choose another format", path,
                                fmt::join(spacing, ", ")));
    return std::make_unique<SdfWriter>(path, field);
}

Field read_sdf(const std::string& path) {
    InputFile file(path);
    Words words(file);
    Field field;
    field.band = Band::full();
    field.sign = SignRule::automatic;
    for (std::int64_t& size : field.grid.size) size = words.number<std::int64_t>("the number of samples");
    for (double& origin : field.grid.origin) origin = words.number<double>("the origin");
    field.grid.spacing.fill(words.number<double>("the spacing"));
    field.grid.validate();
    // Each value has a letter and a blank.
    std::uint64_t room = file.size() / 2;
    for (const std::int64_t size : field.grid.size) room /= static_cast<std::uint64_t>(size);
    if (room == 0)
        file.fail(fmt::format("sizes: {} values do not fit the {} bytes of the file; it is truncated",
                              fmt::join(field.grid.size, " x "), file.size()));
    const std::size_t count = field.grid.sample_count();
    field.distance.reserve(count);
    while (field.distance.size() < count) field.distance.push_back(words.number<float>("a value"));
    words.end();
    return field;
}

}  // namespace clsdf
