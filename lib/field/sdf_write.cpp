#include "core/uninitialized_vector.hpp"
#include "field/formats.hpp"

#include <fmt/compile.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/parallel_pipeline.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

namespace clsdf {
namespace {

constexpr std::size_t chunk = std::size_t{1} << 14;  // values whose text stays in a core's cache
constexpr std::size_t longest_line = 32;             // a float's shortest text has 17 letters at most

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
            std::memcpy(end, line.data(), longest_line);  // of constant size, which is cheaper; the next one covers it
            end += length;
        }
        length_ = static_cast<std::size_t>(end - letters_.data());
    }

    std::string_view view() const { return {letters_.data(), length_}; }

private:
    UninitializedVector<char> letters_;
    std::size_t length_ = 0;
};

/// SDFGen's text (github.com/christopherbatty/SDFGen): the samples along x, y and z, the position of the first one, the
/// one spacing, and the values, one on a line, x fastest.
class SdfWriter : public FormatWriter {
public:
    SdfWriter(const std::string& path, const FieldDescription& field) : file_(path) {
        const Grid& grid = field.grid;
        file_.write(fmt::format("{}\n{}\n{}\n", fmt::join(grid.size, " "), fmt::join(grid.position(0, 0, 0), " "),
                                grid.spacing[0]));
    }

    /// Chunks become text on all cores while those before are written. As many are on their way as there are texts,
    /// and they end in their order: when one begins, the chunk that had its text before has been written.
    void append(const FieldSlab& slab, std::int64_t) override {
        std::size_t begin = 0, turn = 0;
        const auto next = [&](tbb::flow_control& flow) {
            if (begin == slab.distance.size()) {
                flow.stop();
                return Chunk{};
            }
            const std::size_t count = std::min(chunk, slab.distance.size() - begin);
            const Chunk next_chunk{slab.distance.subspan(begin, count), &texts_[turn++ % texts_.size()]};
            begin += count;
            return next_chunk;
        };
        const auto make_text = [](const Chunk& values) {
            values.text->set(values.values);
            return values.text;
        };
        const auto write = [&](const Text* text) { file_.write(text->view()); };
        constexpr auto in_order = tbb::filter_mode::serial_in_order;
        tbb::parallel_pipeline(texts_.size(),
                               tbb::make_filter<void, Chunk>(in_order, next) &
                                   tbb::make_filter<Chunk, Text*>(tbb::filter_mode::parallel, make_text) &
                                   tbb::make_filter<Text*, void>(in_order, write));
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

std::unique_ptr<FormatWriter> sdf_writer(const std::string& path, const FieldDescription& field, const Outputs&) {
    const Vec3& spacing = field.grid.spacing;
    if (spacing[1] != spacing[0] || spacing[2] != spacing[0])
        throw Error(ErrorCode::unsupported,
                    fmt::format("{}: .sdf has one spacing for all axes, not {}; choose another format", path,
                                fmt::join(spacing, ", ")));
    return std::make_unique<SdfWriter>(path, field);
}

}  // namespace clsdf
