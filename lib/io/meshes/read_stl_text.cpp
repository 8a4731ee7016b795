#include "core/large_memory.hpp"
#include "core/parallel.hpp"
#include "io/meshes/face_groups.hpp"
#include "io/meshes/mesh_files.hpp"
#include "io/meshes/polygons.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

namespace clsdf {

namespace {

using Irregularity = StlIrregularity;

constexpr std::string_view begin_of_solid = "solid", end_of_solid = "endsolid";

bool is(std::string_view word, std::string_view keyword) {
    return equals_ignoring_case(word, keyword);
}

/// Whether the word is the keyword, or the keyword with a name joined to it.
bool begins_with(std::string_view word, std::string_view keyword) {
    return is(word.substr(0, keyword.size()), keyword);
}

bool is_keyword(std::string_view word) {
    constexpr std::array<std::string_view, 7> keywords{"facet",   "outer",    "vertex", "end",
                                                       "endloop", "endfacet", "solid"};
    return begins_with(word, end_of_solid) ||
           std::ranges::any_of(keywords, [&](std::string_view keyword) { return is(word, keyword); });
}

bool is_number(std::string_view word) {
    constexpr std::string_view begins = "+-.0123456789";
    return !word.empty() &&
           (begins.find(word[0]) != std::string_view::npos || begins_with(word, "nan") || begins_with(word, "inf"));
}

/// Whether the text goes on as a facet, or a loop without a facet, does. Names of solids may have the same words.
bool facet_begins(TextScanner ahead) {
    std::string_view word = ahead.word();
    if (is(word, "facet")) {
        word = ahead.word_of_text();
        if (is(word, "normal")) word = ahead.word_of_text();
        for (int k = 0; k < 3 && is_number(word); ++k) word = ahead.word_of_text();
    }
    return is(word, "outer") && is(ahead.word_of_text(), "loop") && is(ahead.word_of_text(), "vertex");
}

/// Takes the second word of "end loop", "end facet" or "end solid", if the first is "end". Returns "endloop" etc. in
/// this and the usual spelling, and any other word as it is.
std::string_view joined_end(TextScanner& scanner, std::string_view word) {
    if (!is(word, "end")) return word;
    TextScanner ahead = scanner;
    const std::string_view second = ahead.word_of_text();
    for (const std::string_view keyword : {"endloop", "endfacet", "endsolid"})
        if (is(second, keyword.substr(3))) {
            scanner = ahead;
            return keyword;
        }
    return word;
}

/// Reads a text, or a part of one that begins in a solid and between facets.
class StlText {
public:
    /// notes: of irregularities and, if that is asked for, bad facets; both are errors without them.
    StlText(std::string_view text, const std::string& path, bool begins_in_solid, ReadingNotes* notes)
        : scanner_(text, path, {}), before_(scanner_), notes_(notes), in_solid_(begins_in_solid) {}

    /// Facets until no more than `rest` bytes of the text are left, or else until the text ends.
    void read(std::optional<std::size_t> rest) {
        while (!(rest && in_solid_ && scanner_.remaining() <= *rest)) {
            const std::string_view word = keyword();
            if (word.empty() && (!in_solid_ || !mesh.triangles.empty())) {
                if (in_solid_) note(Irregularity::end_missing);
                return;
            }
            if (begins_with(word, begin_of_solid))
                read_begin_of_solid(word);
            else if (begins_with(word, end_of_solid))
                read_end_of_solid(word);
            else if (in_solid_ && is(word, "facet"))
                read_facet();
            else if (in_solid_ && is(word, "outer"))
                read_loop_without_facet();
            else
                scanner_.fail_word(in_solid_ ? "'facet' or 'endsolid'" : "'solid'", word);
        }
    }

    /// Whether the text that was read ends between facets and before its last bytes.
    bool ends_before(std::size_t rest) const { return in_solid_ && scanner_.remaining() == rest; }

    MeshArrays mesh;
    UncutPolygons uncut;

private:
    void note(Irregularity irregularity, std::size_t line) {
        if (notes_ == nullptr) scanner_.fail("the text is irregular");
        notes_->stl[static_cast<std::size_t>(irregularity)].add([&] { return fmt::format("line {}", line); });
    }
    void note(Irregularity irregularity) { note(irregularity, scanner_.line()); }

    /// The next word, after comments and colours.
    std::string_view keyword() {
        for (;;) {
            before_ = scanner_;
            const std::string_view word = joined_end(scanner_, scanner_.word_of_text());
            if (word.starts_with('#')) {
                note(Irregularity::comment);
                while (!scanner_.at_end_of_line()) scanner_.word();
            } else if (is(word, "color") || is(word, "colour")) {
                note(Irregularity::colour);
                skip_colour();
            } else {
                return word;
            }
        }
    }
    /// The next keyword() is the last one again.
    void put_back() { scanner_ = before_; }

    void expect(std::string_view expected) {
        const std::string_view word = keyword();
        if (!is(word, expected)) scanner_.fail_word(fmt::format("'{}'", expected).c_str(), word);
    }

    /// The rest of the line, or its words before a keyword.
    void skip_colour() {
        while (!scanner_.at_end_of_line()) {
            TextScanner ahead = scanner_;
            if (is_keyword(ahead.word())) return;
            scanner_ = ahead;
        }
    }

    /// The name is the rest of the line, or what is before a facet that begins there.
    void read_begin_of_solid(std::string_view word) {
        if (in_solid_) note(Irregularity::end_missing_between);
        std::string name(word.substr(begin_of_solid.size()));
        if (!name.empty()) note(Irregularity::name_joined);
        while (!scanner_.at_end_of_line()) {
            if (facet_begins(scanner_)) {
                note(Irregularity::facet_behind_name);
                break;
            }
            name.append(name.empty() ? "" : " ").append(scanner_.word());
        }
        mesh.runs.push_back({mesh.triangles.size(), name});
        in_solid_ = true;
    }

    /// The rest of the line is a name, too, unless it begins a solid: one that has a facet on this line, or whose facet
    /// is the next word.
    void read_end_of_solid(std::string_view word) {
        if (!in_solid_) note(Irregularity::end_without_solid);
        if (word.size() > end_of_solid.size()) note(Irregularity::name_joined);
        in_solid_ = false;
        std::optional<TextScanner> solid;
        while (!scanner_.at_end_of_line()) {
            if (facet_begins(scanner_)) {  // in no solid, it is refused as on a line of its own
                if (solid) scanner_ = *solid;
                return;
            }
            const TextScanner before = scanner_;
            if (begins_with(scanner_.word(), begin_of_solid) && !solid) solid = before;
        }
        if (!solid) return;
        TextScanner ahead = scanner_;
        if (is(ahead.word_of_text(), "facet")) scanner_ = *solid;
    }

    void read_facet() {
        const std::size_t line = scanner_.line();
        std::string_view word = keyword();
        const bool has_keyword = is(word, "normal");
        if (has_keyword) word = keyword();
        const bool has_normal = !is(word, "outer");
        if (has_normal) {
            if (!has_keyword && !is_number(word)) scanner_.fail_word("'normal'", word);
            // The normal follows from the vertices, and is written as NaN for faces without area.
            for (int k = 1; k < 3; ++k) word = scanner_.word_of_text();
            if (word.empty()) scanner_.fail_word("a normal", {});
            expect("outer");
        }
        if (!has_keyword || !has_normal) note(Irregularity::normal_missing, line);
        expect("loop");
        read_loop(line);
        word = keyword();
        if (is(word, "endfacet")) return;
        const bool ends =
            word.empty() || is(word, "facet") || begins_with(word, end_of_solid) || begins_with(word, begin_of_solid);
        if (!ends) scanner_.fail_word("'endfacet'", word);
        note(Irregularity::end_of_facet_missing, line);
        put_back();
    }

    void read_loop_without_facet() {
        const std::size_t line = scanner_.line();
        note(Irregularity::loop_without_facet);
        expect("loop");
        read_loop(line);
        if (!is(keyword(), "endfacet")) put_back();
    }

    /// What is behind "outer loop", with "endloop".
    void read_loop(std::size_t line_of_facet) {
        const bool skips = notes_ != nullptr && notes_->skip_bad_facets;
        const std::size_t first = mesh.vertices.size();
        std::optional<Vec3> bad;
        for (;;) {
            const std::string_view word = keyword();
            if (is(word, "endloop")) break;
            if (!is(word, "vertex")) scanner_.fail_word("'vertex' or 'endloop'", word);
            Vec3 vertex;
            for (double& coordinate : vertex) {
                coordinate = scanner_.real("a coordinate");
                if (!std::isfinite(coordinate) && !skips)
                    scanner_.fail(ErrorCode::invalid_mesh,
                                  fmt::format("a coordinate is not finite: {}{}", coordinate, bad_facets_remedy));
            }
            mesh.vertices.push_back(vertex);
            if (!bad && !is_finite(vertex)) bad = vertex;
        }
        const std::size_t corners = mesh.vertices.size() - first;
        if (corners < 3) scanner_.fail(fmt::format("a facet needs three vertices or more, not {}", corners));
        const auto begin = static_cast<std::uint32_t>(first);
        if (bad) {
            mesh.vertices.resize(first);
            notes_->skip_face(fmt::format("line {}", line_of_facet), *bad);
        } else if (corners == 3) {
            mesh.triangles.push_back({begin, begin + 1, begin + 2});
        } else {
            std::vector<std::uint32_t> polygon(corners);
            std::iota(polygon.begin(), polygon.end(), begin);
            Polygons polygons;
            polygons.add(mesh, polygon);
            uncut.add(polygons.triangulate(mesh));
        }
    }

    TextScanner scanner_, before_;  // before_: the last keyword
    ReadingNotes* notes_;
    bool in_solid_;
};

/// The offsets of parts of a text that can be read in parallel. A part begins after what looks like the end of a facet.
std::vector<std::size_t> begins_of_parts(std::string_view text) {
    constexpr std::size_t part_bytes = std::size_t{1} << 20;
    constexpr std::string_view end_of_facet = "endfacet";
    std::vector<std::size_t> begins{0};
    while (text.size() - begins.back() > part_bytes) {
        const std::size_t end = text.find(end_of_facet, begins.back() + part_bytes);
        if (end == std::string_view::npos) break;
        begins.push_back(end + end_of_facet.size());
    }
    return begins;
}

/// Resizes an empty vector, on huge pages if it is large.
template <class Value>
void resize_on_huge_pages(std::vector<Value>& values, std::size_t size) {
    values.reserve(size);
    advise_huge_pages(values.data(), size * sizeof(Value));
    values.resize(size);
}

MeshArrays joined(std::span<const MeshArrays> parts) {
    std::vector<std::size_t> first_vertex{0}, first_triangle{0};
    for (const MeshArrays& part : parts) {
        first_vertex.push_back(first_vertex.back() + part.vertices.size());
        first_triangle.push_back(first_triangle.back() + part.triangles.size());
    }
    MeshArrays mesh;
    resize_on_huge_pages(mesh.vertices, first_vertex.back());
    resize_on_huge_pages(mesh.triangles, first_triangle.back());
    for_each_index(
        parts.size(),
        [&](std::size_t i) {
            std::ranges::copy(parts[i].vertices, mesh.vertices.data() + first_vertex[i]);
            const auto first = static_cast<std::uint32_t>(first_vertex[i]);
            std::ranges::transform(parts[i].triangles, mesh.triangles.data() + first_triangle[i],
                                   [first](const Triangle& triangle) -> Triangle {
                                       return {first + triangle[0], first + triangle[1], first + triangle[2]};
                                   });
        },
        1);
    // A part that begins in a solid goes on with the run before it.
    for (std::size_t i = 0; i < parts.size(); ++i)
        for (const GroupRun& run : parts[i].runs)
            mesh.runs.push_back({first_triangle[i] + run.first_triangle, run.name});
    return mesh;
}

/// Reads the parts of a text on all cores. Nothing if one of them has an error or an irregularity, or does not end
/// where the next one begins, in a solid and between facets: if all do, this is what reading them one after the other
/// gives.
std::optional<MeshArrays> read_parts(std::string_view text, const std::string& path, UncutPolygons& uncut) {
    const std::vector<std::size_t> begins = begins_of_parts(text);
    if (begins.size() == 1) return {};
    std::vector<MeshArrays> parts(begins.size());
    std::vector<UncutPolygons> uncut_of_parts(begins.size());
    std::atomic<bool> all_fit = true;
    for_each_index(
        parts.size(),
        [&](std::size_t i) {
            if (!all_fit) return;
            StlText part(text.substr(begins[i]), path, i > 0, nullptr);
            const bool is_last = i + 1 == parts.size();
            const std::size_t rest = is_last ? 0 : text.size() - begins[i + 1];
            try {
                part.read(is_last ? std::nullopt : std::optional(rest));
                if (!is_last && !part.ends_before(rest)) all_fit = false;
            } catch (const Error&) {
                all_fit = false;
            }
            parts[i] = std::move(part.mesh);
            uncut_of_parts[i] = part.uncut;
        },
        1);
    if (!all_fit) return {};
    std::size_t triangles = 0;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        uncut_of_parts[i].first_triangle += triangles;
        uncut.add(uncut_of_parts[i]);
        triangles += parts[i].triangles.size();
    }
    return joined(parts);
}

}  // namespace

bool begins_as_text_of_stl(std::string_view text, const std::string& path) {
    TextScanner scanner(text, path, {.hash_comments = true});
    return begins_with(scanner.word_of_text(), begin_of_solid);
}

MeshArrays read_stl_text(std::string_view text, const std::string& path, ReadingNotes& notes) {
    if (std::optional<MeshArrays> mesh = read_parts(text, path, notes.uncut)) return std::move(*mesh);
    // As a whole: errors, irregularities and bad facets have their lines here.
    StlText whole(text, path, false, &notes);
    whole.read({});
    notes.uncut = whole.uncut;
    return std::move(whole.mesh);
}

}  // namespace clsdf
