#include "support/device_memory.hpp"
#include "support/exact_field.hpp"
#include "support/hostile_meshes.hpp"
#include "support/random_meshes.hpp"

#include <clsdf/tuning.hpp>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <map>
#include <vector>

// Whatever way a field is asked for, it has the bytes of the plain call, and no other byte of the caller's memory
// changes. This is a table: fields, devices, kinds of memory, and ways of asking (all_ways). A new way is a row.

using namespace clsdf;
using namespace clsdf::test;

namespace {

constexpr std::byte blank{0xAB};

/// What is asked for.
struct Part {
    Grid grid;
    Band band;
    OutputSet outputs;  ///< with the distance
};
struct Fields {
    const char* name;
    Mesh mesh;
    std::vector<Part> parts;
    bool are_blocks = false;  ///< of one lattice, band and size, with the same outputs
    bool are_large = false;   ///< divided on small devices
};

/// How the caller's arrays lie in memory.
struct Kind {
    enum class Layout { packed, unaligned, spread };
    Layout layout = Layout::packed;
    bool on_device = false;
    bool in_double = false;  ///< all outputs that may be doubles

    ElementType type_of(const OutputInfo& info) const {
        return in_double && info.type == ElementType::float32 ? ElementType::float64 : info.type;
    }
};

using Bytes = std::vector<std::byte>;
/// For each part the packed bytes of its outputs.
using Values = std::vector<std::map<Output, Bytes>>;

/// The plain call: one grid, into a field or packed arrays of doubles.
Values plain_call(const Fields& fields, const Kind& kind, KernelBody body) {
    const DistanceTransform transform(test_device(), fields.mesh, {.body = body});
    Values all;
    for (const Part& part : fields.parts) {
        const Field field = transform.compute(part.grid, part.band, part.outputs);
        BOOST_TEST((field.outputs() == part.outputs));
        std::map<Output, Bytes>& values = all.emplace_back();
        OutputTargets doubles;
        for (const OutputInfo& info : output_table()) {
            if (!part.outputs.contains(info.output)) continue;
            Bytes& bytes = values[info.output];
            bytes.assign(field.bytes(info.output).begin(), field.bytes(info.output).end());
            if (kind.type_of(info) != ElementType::float64 || info.type == ElementType::float64) continue;
            bytes.resize(2 * bytes.size());
            doubles[info.output] = OutputArray(reinterpret_cast<double*>(bytes.data()));
        }
        if (kind.in_double) transform.compute(part.grid, part.band, doubles);
    }
    return all;
}

/// One memory with the arrays of all parts.
class Memory {
public:
    Memory(const Fields& fields, const Kind& kind, const Device& device, std::uint64_t seed)
        : fields_(fields), kind_(kind), targets_(fields.parts.size()) {
        for (const OutputInfo& info : output_table())
            for (std::size_t n = 0; n < fields.parts.size(); ++n)
                if (fields.parts[n].outputs.contains(info.output)) {
                    // Blocks lie in the same way, one behind the other.
                    Random random(seed + 100 * detail::index_of(info.output) + (fields.are_blocks ? 0 : 10000 * n));
                    place(n, info, random);
                }
        bytes_.assign(end_ + 64, blank);
        const cl::Context context(device.context(), true);
        if (kind.on_device) {
            queue_ = cl::CommandQueue(context, context.getInfo<CL_CONTEXT_DEVICES>().front());
            buffer_ = cl::Buffer(context, CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR, bytes_.size(), bytes_.data());
        }
        for (const Place& p : places_) {
            OutputArray& array = targets_[p.part][p.info.output];
            static_cast<ArrayLayout&>(array) = p.layout;
            if (kind.on_device) {
                array.device = buffer_();
            } else if (kind.layout == Kind::Layout::spread) {
                array.host = bytes_.data();
                array.bytes = bytes_.size();
            } else {
                array.host = bytes_.data() + array.offset;
                array.bytes = p.samples * p.info.components * bytes_of(array.type);
                array.offset = 0;
            }
        }
    }

    const std::vector<OutputTargets>& targets() const { return targets_; }
    std::vector<Request> requests() const {
        std::vector<Request> requests;
        for (std::size_t n = 0; n < targets_.size(); ++n)
            requests.push_back({fields_.parts[n].grid, fields_.parts[n].band, targets_[n]});
        return requests;
    }
    /// `first`: the first sample of each block, in this order or from the last one on.
    BlockSet blocks(std::vector<Index3>& first, bool from_last) const {
        const Part& part = fields_.parts.front();
        BlockSet blocks{part.grid, part.band, part.grid.size, {}, {}};
        for (const Part& block : fields_.parts) first.push_back(block.grid.first);
        for (const OutputTarget& target : targets_.front().all()) {
            OutputArray& array = blocks.targets[target.output] = target.array;
            const std::ptrdiff_t stride = offset_of(1, target.output) - offset_of(0, target.output);
            const std::ptrdiff_t from_first = stride * static_cast<std::ptrdiff_t>(first.size() - 1);
            if (array.bytes != ArrayLayout::unknown_size && kind_.layout != Kind::Layout::spread)
                array.bytes *= first.size();
            if (from_last) array.offset += static_cast<std::size_t>(from_first);
            if (from_last || kind_.layout == Kind::Layout::spread) array.block_stride = from_last ? -stride : stride;
        }
        if (from_last) std::ranges::reverse(first);
        blocks.first = first;
        return blocks;
    }

    /// Stores values of slices from `slice` on, in packed memory of the host.
    void store(std::size_t part, std::int64_t slice, const FieldSlab& values) {
        const Grid& grid = fields_.parts[part].grid;
        for (const Place& p : places_)
            if (p.part == part) {
                const auto first = static_cast<std::size_t>(slice * grid.size[0] * grid.size[1]);
                std::ranges::copy(
                    values.bytes(p.info.output),
                    bytes_.begin() + static_cast<std::ptrdiff_t>(p.layout.offset + first * p.info.sample_bytes()));
            }
        BOOST_TEST((values.outputs() == fields_.parts[part].outputs));
    }

    /// That it holds the values and nothing else.
    void check(const Values& values) {
        if (kind_.on_device) queue_.enqueueReadBuffer(buffer_, CL_TRUE, 0, bytes_.size(), bytes_.data());
        Bytes expected(bytes_.size(), blank);
        for (const Place& p : places_) write(p, values[p.part].at(p.info.output), expected);
        if (expected == bytes_) return;
        const std::ptrdiff_t byte = std::ranges::mismatch(bytes_, expected).in1 - bytes_.begin();
        const Place* nearest = &places_.front();
        for (const Place& p : places_)
            if (p.begin <= static_cast<std::size_t>(byte)) nearest = &p;
        BOOST_ERROR("byte " << byte << " differs: " << nearest->info.name << " of part " << nearest->part);
    }

private:
    struct Place {
        std::size_t part = 0;
        OutputInfo info;
        ArrayLayout layout;
        std::size_t begin = 0;
        std::size_t samples = 0;
    };

    void place(std::size_t n, const OutputInfo& info, Random& random) {
        Place p{n, info, {}, 0, fields_.parts[n].grid.sample_count()};
        p.layout.type = kind_.type_of(info);
        const std::size_t element = bytes_of(p.layout.type), alignment = 4096, room = random.index(31);
        if (n == 0 || !fields_.are_blocks) {
            end_ = (end_ + alignment - 1) / alignment * alignment;
            if (kind_.layout != Kind::Layout::packed) end_ += element * (1 + room % (128 / element - 1));
        }
        p.begin = p.layout.offset = end_;
        if (kind_.layout == Kind::Layout::spread)
            end_ += spread(p.layout, fields_.parts[n].grid, info.components, random);
        else
            end_ += p.samples * info.components * element;
        places_.push_back(p);
    }
    /// Any axis runs fastest, any axis backwards; samples or components lie side by side, or apart. Returns the bytes.
    static std::size_t spread(ArrayLayout& layout, const Grid& grid, std::size_t components, Random& random) {
        const auto width = static_cast<std::ptrdiff_t>(bytes_of(layout.type));
        std::ptrdiff_t stride = width;
        const auto run = [&](std::ptrdiff_t& step, std::ptrdiff_t count) {
            step = stride;
            stride = stride * count + width * static_cast<std::ptrdiff_t>(random.index(3));
            if (random.index(3) > 0) return;
            layout.offset += static_cast<std::size_t>(step * (count - 1));
            step = -step;
        };
        const bool are_components_together = random.index(2) == 0;
        const auto count = static_cast<std::ptrdiff_t>(components);
        if (are_components_together) run(layout.component_stride, count);
        const std::size_t fastest = random.index(3), sense = 1 + random.index(2);
        for (std::size_t axis = 0; axis < 3; ++axis)
            run(layout.strides[(fastest + sense * axis) % 3], grid.size[(fastest + sense * axis) % 3]);
        if (!are_components_together) run(layout.component_stride, count);
        return static_cast<std::size_t>(stride);
    }

    void write(const Place& p, const Bytes& values, Bytes& to) const {
        std::byte* const first = to.data() + p.layout.offset;
        if (kind_.layout != Kind::Layout::spread) {
            std::ranges::copy(values, first);
            return;
        }
        const Index3& size = fields_.parts[p.part].grid.size;
        const std::size_t element = bytes_of(p.layout.type);
        const std::byte* from = values.data();
        for (std::int64_t z = 0; z < size[2]; ++z)
            for (std::int64_t y = 0; y < size[1]; ++y)
                for (std::int64_t x = 0; x < size[0]; ++x)
                    for (std::size_t c = 0; c < p.info.components; ++c, from += element)
                        std::memcpy(first + x * p.layout.strides[0] + y * p.layout.strides[1] +
                                        z * p.layout.strides[2] +
                                        static_cast<std::ptrdiff_t>(c) * p.layout.component_stride,
                                    from, element);
    }

    std::ptrdiff_t offset_of(std::size_t part, Output output) const {
        for (const Place& p : places_)
            if (p.part == part && p.info.output == output) return static_cast<std::ptrdiff_t>(p.layout.offset);
        return 0;
    }

    const Fields& fields_;
    Kind kind_;
    std::vector<Place> places_;
    std::size_t end_ = 0;
    Bytes bytes_;
    cl::CommandQueue queue_;
    cl::Buffer buffer_;
    std::vector<OutputTargets> targets_;
};

/// A row of the table meets its fields, device and kind of memory.
struct Asking {
    const Fields& fields;
    const Kind& kind;
    const Device& device;
    TransformOptions options;
    const DistanceTransform& transform;
    const Values& values;
    bool is_divided = false;  ///< the device is small
    std::uint64_t seed = 0;

    Memory memory() const { return {fields, kind, device, seed}; }
    /// Of the same kind, with other offsets and strides.
    Memory other_memory(std::uint64_t number = 1) const { return {fields, kind, device, seed + number}; }
    cl::CommandQueue queue(cl_command_queue_properties properties = 0) const {
        const cl::Context context(device.context(), true);
        return {context, context.getInfo<CL_CONTEXT_DEVICES>().front(), properties};
    }
    cl::CommandQueue out_of_order() const { return queue(CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE); }
    void run(Plan& plan, Memory& memory) const {
        enqueue(plan, nullptr).wait();
        memory.check(values);
    }
};

struct Way {
    const char* name;
    bool (*takes)(const Fields& fields, const Kind& kind);
    void (*ask)(const Asking& asking);
};

bool all(const Fields&, const Kind&) {
    return true;
}
bool on_device(const Fields&, const Kind& kind) {
    return kind.on_device;
}
bool blocks(const Fields& fields, const Kind&) {
    return fields.are_blocks;
}
bool blocks_on_device(const Fields& fields, const Kind& kind) {
    return fields.are_blocks && kind.on_device;
}
bool aligned_floats_on_device(const Fields& fields, const Kind& kind) {
    return kind.on_device && !fields.are_blocks && kind.layout == Kind::Layout::packed && !kind.in_double;
}
bool packed_floats_of_the_library(const Fields&, const Kind& kind) {
    return !kind.on_device && kind.layout == Kind::Layout::packed && !kind.in_double;
}

template <bool from_last>
void ask_for_blocks(const Asking& asking) {
    Memory memory = asking.memory();
    std::vector<Index3> first;
    BOOST_TEST(asking.transform.compute(memory.blocks(first, from_last)).slabs > 0U);
    memory.check(asking.values);
}

template <bool has_own_thread>
void ask_for_slabs(const Asking& asking) {
    Memory memory = asking.memory();
    for (std::size_t n = 0; n < asking.fields.parts.size(); ++n) {
        const auto& [grid, band, outputs] = asking.fields.parts[n];
        std::int64_t slices = 0;
        std::size_t slabs = 0;
        const SlabSink sink = [&, &whole = grid](const Grid& part, const FieldSlab& values) {
            BOOST_REQUIRE((part == whole.part({0, 0, slices}, {whole.size[0], whole.size[1], part.size[2]})));
            memory.store(n, slices, values);
            slices += part.size[2];
            ++slabs;
        };
        const SlabOptions options{.sink_has_own_thread = has_own_thread};
        BOOST_TEST(asking.transform.compute(grid, band, outputs, sink, options).slabs == slabs);
        BOOST_TEST(slices == grid.size[2]);
    }
    memory.check(asking.values);
}

const std::vector<Way> all_ways{
    {"a call that returns the field", packed_floats_of_the_library,
     [](const Asking& asking) {
         Memory memory = asking.memory();
         std::size_t slabs = 0;
         for (std::size_t n = 0; n < asking.fields.parts.size(); ++n) {
             const auto& [grid, band, outputs] = asking.fields.parts[n];
             TransformStatistics statistics;
             memory.store(n, 0, asking.transform.compute(grid, band, outputs, {}, &statistics).slab());
             slabs += statistics.slabs;
         }
         memory.check(asking.values);
         if (asking.is_divided) BOOST_TEST(slabs > asking.fields.parts.size());
     }},
    {"a call for each", all,
     [](const Asking& asking) {
         Memory memory = asking.memory();
         for (const Request& request : memory.requests())
             asking.transform.compute(request.grid, request.band, request.targets);
         memory.check(asking.values);
     }},
    {"a call for all", all,
     [](const Asking& asking) {
         Memory memory = asking.memory();
         asking.transform.compute(memory.requests());
         memory.check(asking.values);
     }},
    {"blocks", blocks, ask_for_blocks<false>},
    {"blocks from the last one on", blocks, ask_for_blocks<true>},
    {"slabs for a sink", packed_floats_of_the_library, ask_for_slabs<false>},
    {"slabs for a sink with a thread of its own", packed_floats_of_the_library, ask_for_slabs<true>},
    {"a plan for each", on_device,
     [](const Asking& asking) {
         Memory memory = asking.memory();
         for (const Request& request : memory.requests()) {
             Plan plan = asking.transform.plan(request);
             for (int run = 0; run < 2; ++run) enqueue(plan, nullptr).wait();
         }
         memory.check(asking.values);
     }},
    {"a plan for all", on_device,
     [](const Asking& asking) {
         Memory memory = asking.memory();
         Plan plan = asking.transform.plan(memory.requests());
         for (const cl::CommandQueue& queue : {asking.queue(), asking.out_of_order()}) {
             enqueue(plan, queue()).wait();
             memory.check(asking.values);
         }
     }},
    {"a plan of a grid, whose runs have targets and are under way at once", aligned_floats_on_device,
     [](const Asking& asking) {
         const cl::CommandQueue one = asking.out_of_order(), other = asking.queue();
         std::array<Memory, 4> memory{asking.memory(), asking.memory(), asking.memory(), asking.memory()};
         const std::array<cl_command_queue, 4> queues{one(), one(), other(), nullptr};
         for (std::size_t n = 0; n < asking.fields.parts.size(); ++n) {
             const auto& [grid, band, outputs] = asking.fields.parts[n];
             Plan plan = asking.transform.plan(grid, band, outputs);
             std::vector<cl::Event> ends;
             for (std::size_t run = 0; run < queues.size(); ++run)
                 ends.push_back(enqueue(plan, queues[run], memory[run].targets()[n]));
             cl::Event::waitForEvents(ends);
         }
         for (Memory& m : memory) m.check(asking.values);
     }},
    {"a plan whose runs have other targets and are under way at once", on_device,
     [](const Asking& asking) {
         Memory memory = asking.memory(), other = asking.other_memory(), third = asking.other_memory(2);
         Plan plan = asking.transform.plan(memory.requests());
         const cl::CommandQueue queue = asking.out_of_order();
         const cl::Event first = enqueue(plan, queue(), other.targets()), second = enqueue(plan, queue()),
                         last = enqueue(plan, queue(), third.targets());
         cl::Event::waitForEvents({first, second, last});
         for (Memory* m : {&memory, &other, &third}) m->check(asking.values);
     }},
    {"a plan beside another one and a call", on_device,
     [](const Asking& asking) {
         if (asking.fields.are_large) return;  // a small device has no memory for two such plans
         Memory memory = asking.memory(), other = asking.other_memory();
         Plan plan = asking.transform.plan(memory.requests()), second = asking.transform.plan(other.requests());
         asking.transform.compute(asking.fields.parts.front().grid, Band::full());
         const cl::CommandQueue queue = asking.queue(), other_queue = asking.queue();
         const cl::Event end = enqueue(plan, queue()), other_end = enqueue(second, other_queue());
         cl::Event::waitForEvents({end, other_end});
         for (Memory* m : {&memory, &other}) m->check(asking.values);
     }},
    {"a plan that had other positions", on_device,
     [](const Asking& asking) {
         const std::vector<Vec3>& positions = asking.fields.mesh.vertices();
         std::vector<Vec3> others = positions;
         for (Vec3& p : others) p = {1.1 * p[0] + 0.1, p[1] - 0.05 * p[0], 0.9 * p[2]};
         DistanceTransform transform(asking.device, asking.fields.mesh, asking.options);
         transform.set_positions(others);
         Memory memory = asking.memory();
         Plan plan = transform.plan(memory.requests());
         enqueue(plan, nullptr).wait();
         transform.set_positions(positions);
         plan.update(transform);
         asking.run(plan, memory);
     }},
    {"a plan that had other grids", on_device,
     [](const Asking& asking) {
         Memory memory = asking.memory();
         std::vector<Request> others = memory.requests();
         std::vector<Grid> grids;
         for (std::size_t n = 0; n < others.size(); ++n) {
             grids.push_back(others[n].grid);
             others[n].grid.first[n % 3] += 5 + static_cast<std::int64_t>(n) % 20;
         }
         Plan plan = asking.transform.plan(others);
         enqueue(plan, nullptr).wait();
         plan.update(asking.transform, grids);
         BOOST_TEST((plan.requests().back().grid == grids.back()));
         asking.run(plan, memory);
     }},
    {"a plan that had other requests", on_device,
     [](const Asking& asking) {
         Memory memory = asking.memory(), other = asking.other_memory();
         const std::vector<Request> few = {other.requests().back()};
         Plan plan = asking.transform.plan(few);
         for (int turn = 0; turn < 2; ++turn) {
             plan.update(asking.transform, memory.requests());
             BOOST_TEST(plan.requests().size() == asking.fields.parts.size());
             asking.run(plan, memory);
             plan.update(asking.transform, few);
         }
     }},
    {"a plan of blocks", blocks_on_device, [](const Asking& asking) {
         Memory memory = asking.memory(), other = asking.other_memory();
         std::vector<Index3> first, reversed;
         Plan plan = asking.transform.plan(memory.blocks(first, false));
         asking.run(plan, memory);
         plan.update(asking.transform, other.blocks(reversed, true));
         asking.run(plan, other);
     }}};

Grid block_anywhere(const Grid& lattice, const Index3& size, Random& random) {
    Index3 first{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        first[axis] = lattice.first[axis] - 8 + random.index(static_cast<std::size_t>(lattice.size[axis]) + 8);
    return lattice.block(first, size);
}

Fields boxes_of_three_levels() {
    Random random(20261122);
    Fields fields{"boxes of three levels", make_shape("knot"), {}};
    const Grid coarse = grid_around(fields.mesh, 40, 4);
    for (int n = 0; n < 16; ++n) {
        const Grid level = n % 3 == 0 ? coarse : n % 3 == 1 ? coarse.refined(2) : coarse.refined_cells(4);
        const Index3 size{1 + random.index(24), 1 + random.index(24), 1 + random.index(24)};
        const OutputSet outputs = n % 8 == 0   ? all_outputs()
                                  : n % 4 == 0 ? Output::triangle | Output::site
                                               : OutputSet();
        fields.parts.push_back({block_anywhere(level, size, random),
                                n % 7 == 5 ? Band::full() : Band::symmetric(3 * level.voxel()),
                                Output::distance | outputs});
    }
    return fields;
}

/// Some share samples, some lie beyond the mesh.
Fields equal_blocks() {
    Random random(31);
    Fields fields{"equal blocks", make_shape("knot"), {}, true};
    const Grid lattice = grid_around(fields.mesh, 60, 4);
    for (int n = 0; n < 40; ++n)
        fields.parts.push_back(
            {block_anywhere(lattice, {9, 7, 5}, random), Band::symmetric(3 * lattice.voxel()), all_outputs()});
    return fields;
}

/// Patches with ghost samples fill a grid and are computed as one block; another box is far away.
Fields patches() {
    Fields fields{"patches", make_shape("sphere4"), {}};
    const Grid grid = grid_around(fields.mesh, 64, 4).block({-32, -32, -32}, {64, 64, 64});
    const Band band = Band::symmetric(3 * grid.voxel());
    for (std::int64_t n = 0; n < 64; ++n)
        fields.parts.push_back(
            {grid.part({n % 4 * 16, n / 4 % 4 * 16, n / 16 * 16}, {16, 16, 16}).grown(2), band, Output::distance});
    fields.parts.push_back({grid.block({50000, 50000, -50000}, {4, 5, 6}), band, Output::distance});
    return fields;
}

/// Rows that begin and end anywhere; stores are of whole lines of memory.
Fields rows_of_any_length() {
    Fields fields{"rows of any length", tilted(make_shape("knot")), {}};
    const Grid lattice = grid_around(fields.mesh, 40, 5);
    for (const Index3& size : {Index3{71, 40, 33}, Index3{64, 24, 40}, Index3{9, 5, 70}})
        fields.parts.push_back(
            {lattice.block({3, -5, 2}, size), Band::symmetric(lattice.voxel()), Output::distance | Output::triangle});
    fields.parts.push_back({lattice, Band::full(), Output::distance | Output::triangle});
    return fields;
}

/// Whole rows of bricks are stored as runs.
Fields small_triangles() {
    Fields fields{"small triangles", tilted(make_shape("sphere5")), {}};
    Grid grid = grid_around(fields.mesh, 48, 4);
    grid.origin = {};  // the centre
    const Band band = Band::symmetric(4 * grid.voxel());
    fields.parts = {{grid.block({-40, -32, -31}, {64, 64, 64}), band, Output::distance | Output::triangle},
                    {grid.block({-32, -30, -32}, {61, 61, 61}), band, Output::distance}};
    return fields;
}

/// Long along z: slabs of coarse bricks, of bricks and of less, from any slice on.
Fields large_grids() {
    Random random(5);
    Fields fields{"large grids", random_sphere(random, "sphere3", 0.2), {}};
    fields.are_large = true;
    Grid grid = grid_around(fields.mesh, 48, 4);
    grid.origin[2] += grid.spacing[2] * 13;
    grid.first[2] = -13;
    grid.size[2] = 90;
    const double h = grid.voxel();
    fields.parts = {{grid, Band::symmetric(4 * h), all_outputs()},
                    {grid, {std::numeric_limits<double>::infinity(), 2 * h}, Output::distance | Output::triangle}};
    return fields;
}

const std::vector<Fields>& all_fields() {
    static const std::vector<Fields> fields{boxes_of_three_levels(), equal_blocks(),    patches(),
                                            rows_of_any_length(),    small_triangles(), large_grids()};
    return fields;
}

/// Every way of asking on a device, for fields that are chosen.
template <typename Choice>
void check_all_ways(const Device& device, KernelBody body, bool is_divided, Choice is_chosen) {
    std::uint64_t seed = 1;
    for (const Fields& fields : all_fields()) {
        const TransformOptions options{.body = body};
        const DistanceTransform transform(device, fields.mesh, options);
        for (const bool in_double : {false, true})
            for (const auto layout : {Kind::Layout::packed, Kind::Layout::unaligned, Kind::Layout::spread}) {
                Kind kind{layout, false, in_double};
                if (!is_chosen(fields, kind)) continue;
                const Values values = plain_call(fields, kind, body);
                for (const bool is_on_device : {false, true}) {
                    kind.on_device = is_on_device;
                    seed += 1000003;
                    const Asking asking{fields, kind, device, options, transform, values, is_divided, seed};
                    for (const Way& way : all_ways)
                        if (way.takes(fields, kind))
                            BOOST_TEST_CONTEXT(way.name << ": " << fields.name << ", layout " << int(layout)
                                                        << (in_double ? ", doubles" : ", floats")
                                                        << (is_on_device ? " on the device" : " on the host")
                                                        << ", seed " << seed)
                    try {
                        way.ask(asking);
                    } catch (const Error& error) {
                        BOOST_ERROR(error.what());
                    }
                }
            }
    }
}

/// Packed floats and spread doubles: a part of the table that takes less time.
bool is_sampled(const Fields&, const Kind& kind) {
    return kind.layout == (kind.in_double ? Kind::Layout::spread : Kind::Layout::packed);
}
bool is_large(const Fields& fields, const Kind& kind) {
    return fields.are_large && is_sampled(fields, kind);
}

/// The tests' device as if it allocated at most so many slices of the large grids' closest points at once.
Device with_largest_slab(std::int64_t slices) {
    const Index3& size = all_fields().back().parts.front().grid.size;
    return with_largest_allocation(static_cast<std::size_t>(slices * size[0] * size[1]) * 3 * sizeof(double));
}

}  // namespace

BOOST_AUTO_TEST_CASE(every_way_of_asking_gives_the_bytes_of_the_plain_call) {
    check_all_ways(test_device(), KernelBody::by_vector, false, [](const Fields& fields, const Kind& kind) {
        const bool is_left_out = kind.in_double && kind.layout == Kind::Layout::unaligned;
        return fields.are_large ? is_sampled(fields, kind) : !is_left_out;
    });
    check_all_ways(test_device(), KernelBody::by_group, false, [](const Fields& fields, const Kind& kind) {
        return !fields.are_large && is_sampled(fields, kind);
    });
}

BOOST_AUTO_TEST_CASE(and_on_a_device_that_allocates_little_at_once) {
    check_all_ways(with_largest_slab(21), KernelBody::by_group, true, is_large);
    check_all_ways(with_largest_slab(5), KernelBody::by_vector, true, is_large);
}

BOOST_AUTO_TEST_CASE(and_on_a_device_with_little_memory) {
    const Device device = test_device().limited({.memory = std::size_t{12} << 20});
    check_all_ways(device, KernelBody::by_vector, false, is_large);
    // A plan whose arrays are copied is divided.
    const Fields& fields = all_fields().back();
    const Memory memory(fields, {Kind::Layout::spread, true, true}, device, 1);
    BOOST_TEST(DistanceTransform(device, fields.mesh).plan(memory.requests().front()).statistics().slabs > 1U);
}

BOOST_AUTO_TEST_CASE(and_on_a_device_whose_queue_is_out_of_order) {
    const cl::Context context(test_device().context(), true);
    const cl::Device device = context.getInfo<CL_CONTEXT_DEVICES>().front();
    const cl::CommandQueue queue(context, device, CL_QUEUE_OUT_OF_ORDER_EXEC_MODE_ENABLE);
    check_all_ways(Device::from_handles(context(), device(), queue()), KernelBody::by_vector, false,
                   [](const Fields& fields, const Kind& kind) { return fields.are_blocks && !kind.in_double; });
}
