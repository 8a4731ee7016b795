#pragma once

#include <clsdf/calls.hpp>
#include <clsdf/device.hpp>
#include <clsdf/export.hpp>
#include <clsdf/field.hpp>
#include <clsdf/link_plan.hpp>
#include <clsdf/mesh.hpp>
#include <clsdf/outputs.hpp>
#include <clsdf/plan.hpp>
#include <clsdf/point_plan.hpp>
#include <clsdf/segments.hpp>
#include <clsdf/sparse.hpp>
#include <clsdf/sparse_plan.hpp>
#include <clsdf/topology.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace clsdf {

enum class KernelBody : std::int32_t;  // clsdf/tuning.hpp

/// The surface that distances are measured to. The values of the enumerators never change.
enum class Surface : std::int32_t {
    given = 0,  ///< all faces as given, also within other parts
    outer = 1,  ///< the outer surface of overlapping parts, see outer()
};

/// "given", "outer".
CLSDF_EXPORT const char* name_of(Surface surface);

/// The surface, how the sign is decided, and what is kept between calls.
struct TransformOptions {
    SignRule sign = SignRule::automatic;
    /// Limit of the device memory that is kept between calls, in bytes; 0 keeps nothing. Data that all grids and points
    /// share is kept first, then the lattices and grids that were used last. The default suits the grids of a time
    /// step; DistanceTransform::memory() says what is kept.
    std::optional<std::size_t> kept_bytes{};
    KernelBody body{};  ///< for measuring
    /// Of the rule `below`, which needs one, and no other: z of the floor, below all vertices, also when they move.
    std::optional<double> floor{};
    /// outer: all calls are about the outer surface alone, and tell its triangles by the faces as given that they are
    /// parts of (docs/outer.md). Of sign rules it takes those that outer() takes.
    Surface surface = Surface::given;
};

namespace detail {
struct TransformAccess;
}

/// The exact distance to a mesh: on grids, on many boxes of any lattices, and at points.
///
/// A transform prepares the mesh when a call first needs it. It keeps the data of grids within
/// TransformOptions::kept_bytes. Neither changes a byte of a field. The bytes depend on the mesh's first and last
/// positions, the lattice (origin and spacing), the band and the device. They do not depend on the block of the lattice
/// that is computed, on other calls or on threads.
///
/// Members that are const may be called from several threads at once; their work takes turns on the device.
/// set_positions(), set_motion(), assignment and the destructor need the transform for themselves. Calls that return
/// results wait for earlier commands of the device's queue. If one of these waits for an event of the caller's, another
/// thread must set it. Once moved from, every member but assignment and the destructor throws Error(invalid_argument).
///
/// Method: R. Peikert and C. Sigg, Optimized Bounding Polyhedra for GPU-Based Distance Transform, 2006, with polyhedra
/// that lose no sample (docs/method.md).
class CLSDF_EXPORT DistanceTransform {
public:
    // Make.

    /// Copies and checks the mesh and describes its topology. Compiles nothing: the first call that needs a program
    /// does. Of `call`, should_stop and log count. Throws Error(invalid_mesh), also if it does not meet the sign rule;
    /// Error(invalid_argument) for a floor that is missing, not below all vertices, or of another rule than `below`;
    /// Error(device_failure, unsupported, out_of_memory, cancelled).
    DistanceTransform(Device device, const Mesh& mesh, const TransformOptions& options = {},
                      const CallOptions& call = {});
    /// The view's arrays may be memory of the device's context; they are read after the events of
    /// CallOptions::wait_list, and may change when the constructor returns. If both are, and a GPU makes the topology,
    /// they do not come to the host until a call of the host needs them.
    DistanceTransform(Device device, const MeshView& mesh, const TransformOptions& options = {},
                      const CallOptions& call = {});
    DistanceTransform(DistanceTransform&&) noexcept;
    DistanceTransform& operator=(DistanceTransform&&) noexcept;
    ~DistanceTransform();

    /// A transform for a part of the domain: the region of a rank, the leaves that it owns. It keeps only the triangles
    /// near the regions and, for a sign, those with smaller x in the rows of their samples. Every grid, point and box
    /// asked for later must lie in a region, with at most its half width and its spacing. Other calls throw
    /// Error(invalid_argument) that names the nearest region. The results have the bytes of the whole transform. The
    /// part cannot be restricted again (Error(unsupported)). The whole transform is prepared first, which blocks. It
    /// may be destroyed afterwards.
    ///
    /// margin: the longest way of a vertex, in the mesh's units, from where it is now, that set_positions() may give
    /// the part; 0 if they stay. The part also keeps the triangles that such motions may bring near the regions, those
    /// around them, and a few vertices from elsewhere that decide values of the whole: part_vertices(). Fields of it
    /// have the bytes of the whole transform at the same positions.
    ///
    /// Throws Error(invalid_argument) that names the index of a region whose box has a coordinate that is not finite or
    /// a lower corner above its upper one, whose half width is not positive and finite, or whose spacing is negative or
    /// not finite, if there is no region, and for a margin that is negative or not finite; Error(unsupported) for a
    /// transform that is restricted already or has polyhedra of clsdf::papers, and for a margin if its surface is
    /// `outer` or it has more than 2^28 triangles; Error(out_of_memory).
    DistanceTransform restrict_to(std::span<const Region> regions, double margin = 0) const;
    DistanceTransform restrict_to(const Region& region, double margin = 0) const {
        return restrict_to(std::span(&region, 1), margin);
    }
    /// The vertices of a part with a margin, ascending, by their numbers in the mesh that the whole transform was made
    /// from; of vertices with equal coordinates, which count as one, the lowest number. set_positions() takes one
    /// position for each. Throws Error(unsupported) if the transform has no margin.
    std::vector<std::uint32_t> part_vertices() const;

    /// A restricted transform as bytes, for another process or for later: from_part() makes it again without the mesh
    /// and without the work of preparing it. The same part has the same bytes. They are this machine's, for programs
    /// with the same version of clsdf: 65 to 70 for each triangle that the part keeps, and up to 180 kB beside; with a
    /// margin about twice as many, and up to 900 kB. While the call lasts, the part is in memory up to four times.
    /// Throws Error(unsupported) if the transform is whole or its surface is `outer`, Error(out_of_memory).
    std::vector<std::byte> part_bytes() const;
    /// The restricted transform of these bytes, on any device, with the results and the refusals of the one that they
    /// were made from. kept_bytes: as TransformOptions has them. Throws Error(invalid_argument) if the bytes are no
    /// part, are not whole or damaged, or of another version; Error(device_failure, unsupported, out_of_memory). The
    /// bytes' hash tells damage, not forgery: read parts of programs that you trust.
    static DistanceTransform from_part(Device device, std::span<const std::byte> bytes,
                                       std::optional<std::size_t> kept_bytes = {});

    /// One copy of a prepared mesh for the processes of a node. share() writes what a whole transform keeps on the host
    /// and what depends on no grid: the mesh, its topology and polyhedra, the trees for points, the signs of faces, the
    /// names and the pseudonormals of sites. from_shared() makes a transform that reads these arrays in place. The
    /// memory is the caller's: POSIX shared memory, a window of MPI, a mapped file. It begins at a multiple of 64
    /// bytes, at any address.
    ///
    /// The size in bytes of that memory: about 640 for each triangle. Makes what is not made yet, so that share() only
    /// copies. Both throw Error(unsupported) for a transform that is restricted (part_bytes() is for those), whose
    /// vertices have moved, whose surface is `outer`, or that has polyhedra of clsdf::papers; Error(device_failure,
    /// out_of_memory).
    std::size_t prepared_bytes() const;
    /// Writes into memory of at least prepared_bytes() bytes, and the head last: until the call returns, from_shared()
    /// refuses the memory. Throws as above, and Error(invalid_argument) if the memory is too small or not aligned.
    void share(std::span<std::byte> memory) const;
    /// The whole transform, with the bytes of the one that was shared, whatever is asked for. The memory must stay as
    /// it is until the transform and its plans are destroyed; it may be read-only. Reads all of it once to check its
    /// hash, which tells damage, not forgery. memory() counts only what the transform has beside it. A device with
    /// memory of its own gets copies; then the host's arrays alone are shared. After set_positions() the values that
    /// follow from positions are the transform's own; the topology stays shared. kept_bytes: as TransformOptions has
    /// them. Throws Error(invalid_argument) if the memory has no transform, or one that is not complete, damaged or of
    /// another version; Error(device_failure, unsupported, out_of_memory).
    static DistanceTransform from_shared(Device device, std::span<const std::byte> memory,
                                         std::optional<std::size_t> kept_bytes = {});

    // Set positions.

    /// Gives the same triangles new positions, one for each vertex of the mesh that the transform was made from. What
    /// follows from the triangles stays: their order, which vertices count as one, topology() and sign(). Fields of
    /// later calls depend on the first and on these positions only. Faces may lose their area and regain it, vertices
    /// that come to coincide stay separate; plans keep the positions they were made with.
    ///
    /// Positions in memory of the device are read after the events of CallOptions::wait_list, and may change when the
    /// call returns. If a GPU has made the topology, they do not come to the host until a call of the host needs them,
    /// unless vertices are joined for the sign.
    ///
    /// With Surface::outer faces are cut anew, which takes as long as a new transform, and topology() and sign() are
    /// those of the mesh at these positions. Of `call`, should_stop counts then; it also throws as outer() does.
    ///
    /// A part that was made with a margin takes one position for each of part_vertices(). It has the margin that it was
    /// made with, counted from the positions of that time. Sums over the whole mesh in TransformStatistics are those of
    /// the triangles that it has. If motions by the margin can turn the mesh inside out, so that the volume that it
    /// encloses would be negative, gradients of a part that has moved are Error(unsupported).
    ///
    /// Throws Error(invalid_argument) if the number of positions differs, if a vertex of a part is farther than its
    /// margin, which names the vertex, for memory that is missing, too small or of another context, if vertices that
    /// had equal coordinates, and count as one, move apart, or if one moves down to the floor of the sign rule `below`;
    /// Error(invalid_mesh) if a vertex in use is not finite; Error(unsupported) for a restricted transform without a
    /// margin or a buffer that the host may not read. After an error the positions are those of before.
    void set_positions(const InputArray& positions, const CallOptions& call = {});

    /// Puts the vertices at R x + t, a rigid motion. x are the positions of the mesh that the transform was made from,
    /// so errors do not add up over many motions. `rotation` has the rows of R. A coordinate is three multiplications
    /// and additions, each rounded once: fma(R[a][0], x[0], fma(R[a][1], x[1], fma(R[a][2], x[2], t[a]))). Throws
    /// Error(invalid_mesh) if a position is not finite, Error(invalid_argument) if R is no rotation: each element of R
    /// R^T may differ from the identity's by 1e-12, and det R must be positive, if t is not finite, or if a vertex
    /// moves down to the floor of the sign rule `below`; Error(unsupported) for a restricted transform.
    void set_motion(const std::array<Vec3, 3>& rotation, const Vec3& translation);

    // Compute.

    /// The field on the host. A large grid is computed in slabs; the bytes are the same. The distance is always among
    /// the outputs. `statistics`, if not null, is set when the call succeeds.
    Field compute(const Grid& grid, const Band& band, OutputSet outputs = Output::distance,
                  const CallOptions& call = {}, TransformStatistics* statistics = nullptr) const;

    /// Into the caller's arrays; the distance must have one. They are all on the host or all on the device. A call that
    /// writes to the device cannot be cancelled while samples are computed. An error leaves the arrays undefined.
    /// Throws Error(invalid_argument) for a grid, a band or an array's memory out of range, for arrays that overlap and
    /// for an event of another context; Error(unsupported) for other types and for a signed field of a mesh beyond the
    /// limits of Grid; Error(out_of_memory, device_failure or cancelled).
    TransformStatistics compute(const Grid& grid, const Band& band, const OutputTargets& targets,
                                const CallOptions& call = {}) const;

    /// Many boxes in one call, in any order, of any lattices, bands and outputs: the patches of a refined mesh, with
    /// their ghost samples. Each gets the bytes of a call of its own. Boxes of one lattice, one band and the same
    /// outputs are computed together if that is cheaper; a sample that several boxes share is computed once then. If a
    /// request is refused, nothing is computed, and the message names its index. Throws what a call for each request
    /// would throw. Progress covers all requests. The statistics are sums; their figures of memory are maxima.
    TransformStatistics compute(std::span<const Request> requests, const CallOptions& call = {}) const;

    TransformStatistics compute(const Request& request, const CallOptions& call = {}) const {
        return compute(std::span(&request, 1), call);
    }

    /// Equal blocks of one lattice in one call, as requests with the same bytes. Messages name block n as request n.
    TransformStatistics compute(const BlockSet& blocks, const CallOptions& call = {}) const;

    /// A field of any size, slab by slab: hands whole slices to the sink in the order of z, at most slabs_of() at a
    /// time. All outputs of a slab are in memory, of two if the sink has its own thread. The bytes are those of the
    /// whole. After an error the sink has returned and is not called again. Throws what the others and the sink throw,
    /// Error(invalid_argument) for an empty sink.
    TransformStatistics compute(const Grid& grid, const Band& band, OutputSet outputs, const SlabSink& sink,
                                const SlabOptions& options = {}, const CallOptions& call = {}) const;

    /// The bricks near the surface, and the sign of the rest: see SparseSlab. Every value has the bytes of the dense
    /// field's, and neither time nor memory grows with the samples far from the surface. The distance is always among
    /// the outputs. The half widths must be finite, of a field without a sign the one outside. A restricted transform
    /// needs regions that hold whole bricks: in_whole_bricks(grid).
    ///
    /// Throws what compute() throws; Error(invalid_argument) for a band without an end or of signs alone;
    /// Error(unsupported) for a transform of clsdf::papers.
    SparseField compute_sparse(const Grid& grid, const Band& band, OutputSet outputs = Output::distance,
                               const CallOptions& call = {}, TransformStatistics* statistics = nullptr) const;

    /// A sparse field of any size, which is handed to the sink in layers of bricks; a few of them are in memory. The
    /// sink is called on the calling thread and may use the transform. After an error it is not called again. Also
    /// throws what the sink throws, Error(invalid_argument) for an empty sink.
    TransformStatistics compute_sparse(const Grid& grid, const Band& band, OutputSet outputs, const SparseSink& sink,
                                       const CallOptions& call = {}) const;

    /// Into the caller's arrays; the distance must have one, unless there is room for no brick. `counts` gets how many
    /// bricks and runs there are. If the arrays have less room, throws Error(invalid_argument) that names both numbers,
    /// and `counts` has them, too; the arrays are undefined then, and nothing is written beyond them. After other
    /// errors `counts` is 0. Also throws Error(invalid_argument) for arrays that overlap or are not of the size,
    /// Error(unsupported) for memory of the device, strides and doubles.
    TransformStatistics compute_sparse(const Grid& grid, const Band& band, const SparseTargets& targets,
                                       SparseCounts& counts, const CallOptions& call = {}) const;

    /// How many bricks and runs compute_sparse() would give. Takes nearly its time, and no memory for values: if a
    /// guess is at hand, compute into arrays of that size, and again if they were too small.
    SparseCounts count_sparse(const Grid& grid, const Band& band, const CallOptions& call = {},
                              TransformStatistics* statistics = nullptr) const;

    /// Many sparse fields in one call, of any lattices, bands and outputs, each with the bytes of a call of its own.
    /// Boxes of one lattice, one band and the same outputs are computed together if that is cheaper. If a request is
    /// refused, nothing is computed, and the message names its index.
    std::vector<SparseField> compute_sparse(std::span<const SparseRequest> requests, const CallOptions& call = {},
                                            TransformStatistics* statistics = nullptr) const;

    /// The slabs of a field on a device that sets no closer limit.
    static std::vector<Grid> slabs_of(const Grid& grid);

    // Query.

    /// The signed distance at points anywhere, in the mesh's units and in any order, and all else that has an array;
    /// docs/library.md, 'Points', says what each output is. Beyond `half_width`, which is not negative and may be
    /// infinite, the distance is `half_width` with the point's sign, and there is no triangle. The sign is that of the
    /// exact winding number (or parity) at the given doubles, see docs/accuracy.md; a point on the surface has the
    /// distance +0. A voxel, as a measure, is 1/256 of the longest side of the mesh's box, or 1 if that has no extent.
    ///
    /// The points and each array may be memory of the host or of the device, and may share a buffer. Outputs may lie on
    /// the points, which are read first. An array has points.count items, packed or strides[0] bytes apart. On a GPU
    /// more than 96 points stay in memory of the device if all arrays are there and no output lies on the points, but
    /// for a short list at most. Otherwise memory of the device is mapped. Until the call returns, no other command or
    /// call may write to an array's buffer between the array's first and last byte.
    ///
    /// A result depends on the point, `half_width` and the mesh's positions: not on other points, their order or
    /// number, not on threads, and not on the device if its arithmetic is that of IEEE 754. The first call prepares the
    /// mesh (memory()). An error leaves the arrays undefined.
    ///
    /// At most 96 points are answered by the calling thread, without a kernel. Any number of threads may ask at once;
    /// once the mesh is prepared they do not wait for other calls of the transform.
    ///
    /// A point that is not finite gets the distance NaN and no triangle. A finite one more than 1e14 voxels from the
    /// mesh's box, or so far that its distance may be beyond the floats, gets `half_width` (outside) if that is finite,
    /// else NaN, and no triangle; in a part of a mesh, too. CallOptions::log gets one warning with their number, which
    /// is TransformStatistics::unusable_points. With CallOptions::refuse_unusable_points they are refused.
    ///
    /// Throws Error(invalid_argument) that names the index of a point that is refused; for a `half_width` that is
    /// negative, NaN or finite beyond a float; for memory too small or of another context, and for arrays that overlap.
    /// Error(unsupported) for a buffer that the host may not read or write; Error(device_failure, wrong_results,
    /// out_of_memory or cancelled).
    TransformStatistics query(const InputArray& points, double half_width, const OutputTargets& targets,
                              const CallOptions& call = {}) const;

    /// Sets the place of each box. Boxes and half_width are in the mesh's units; boxes include their limits, and may be
    /// points. A box is `within` if it is within half_width of the smallest box around a triangle. So a box that is a
    /// little farther than half_width from the surface may be `within`, too. So may a box, with the sign rule
    /// solid_angle, that is near the film where the winding number is one half, and, with the rule below, a box that
    /// the walls or the floor meet. The other answers are exact. Blocks; cannot be cancelled.
    ///
    /// An answer depends on the box, half_width and the mesh's positions alone. Works on the host, on all cores. Keeps
    /// what query() keeps. Throws Error(invalid_argument) that names the index of a box with a coordinate that is not
    /// finite or a lower corner above its upper one, for half_width below 0 or NaN, and if there are not as many places
    /// as boxes; Error(out_of_memory).
    void classify(std::span<const Box> boxes, double half_width, std::span<BoxPlace> places) const;

    /// The generalised winding number at points anywhere: of the surface that decides the sign, or of the mesh if there
    /// is no sign. A closed surface has an integer, with the sign rule parity, too. With open edges the value lies
    /// between; the rule solid_angle takes points with one half or more, or minus one half or less, to be inside. With
    /// the rule below, walls and floor count, and the value is an integer. The
    /// error is that of a float, or 1e-14 for each thousand open edges in an array of doubles, and in both 1e-16 times
    /// the length of an open edge over its distance. On the surface it has the value of one of the sides. A point that
    /// is not finite has NaN.
    ///
    /// Points and results are arrays of the host or of the device as in query(), which says what they throw. Works on
    /// the host, on all cores, and takes for each point as long as crossings and a sum over the open edges. Also throws
    /// Error(unsupported) for a restricted transform whose mesh has open edges, without the sign rule solid_angle or
    /// below.
    void winding(const InputArray& points, const OutputArray& results, const CallOptions& call = {}) const;

    // Meet the surface: links, crossings (docs/segments.md), rays (docs/rays.md).

    /// The links of a grid in these directions, at most 32 with components up to 16, that meet the surface. With
    /// Hits::walls a link has a row if and only if its ends are on different sides; see LinkOptions for others. q is
    /// within 0.51 ulp of the exact place for the doubles of Grid::position(), and from both ends of a link with one
    /// wall adds up to 1 within an ulp. With the rule solid_angle a link may meet the film of an open mesh
    /// (SegmentFlag::film), with the rule `below` walls and floor (SegmentFlag::closing). Hits::faces counts the places
    /// of the faces as given.
    ///
    /// A row depends on the lattice, the direction and the mesh's positions: not on the block of the lattice, other
    /// directions or threads. On a GPU kernels find the links of walls; else the host works, on all cores. Blocks.
    /// Keeps what query() keeps. The grid of a restricted transform, with as many samples more on each side as the
    /// directions reach, must lie in a region, and with the rule `below` above the floor.
    ///
    /// Throws Error(invalid_argument) for directions out of range or given twice, and for a grid out of range, also if
    /// the last bit of a coordinate is above 2^-22 of the spacing, or if a coordinate is not 0 and less than 2^-300 or
    /// more than 2^300 units (see plan_points()); Error(unsupported) for a mesh with such a coordinate and for walls of
    /// a mesh without a sign; Error(out_of_memory or cancelled).
    Links links(const Grid& grid, std::span<const LinkDirection> directions, const LinkOptions& options = {},
                const CallOptions& call = {}, TransformStatistics* statistics = nullptr) const;

    /// Into the caller's arrays. `count` gets how many links there are. If arrays of rows have less room, throws
    /// Error(invalid_argument) that names both numbers, `count` has it, and nothing is written. After other errors
    /// `count` is 0. Memory of the device is written by kernels if all arrays are there and kernels find the links,
    /// else it is mapped. Also throws Error(invalid_argument) for arrays that are too small or overlap and for memory
    /// of another context, Error(unsupported) for other types and for a buffer that the host may not write.
    TransformStatistics links(const Grid& grid, std::span<const LinkDirection> directions, const LinkTargets& targets,
                              std::size_t& count, const LinkOptions& options = {}, const CallOptions& call = {}) const;

    /// The links of a grid of any size, slab by slab, which are slabs_of(grid): the rows one after another are those of
    /// the whole. The memory is that of a slab. The sink is called on the calling thread. After an error it is not
    /// called again. Also throws what the sink throws, Error(invalid_argument) for an empty sink.
    TransformStatistics links(const Grid& grid, std::span<const LinkDirection> directions, const LinkSink& sink,
                              const LinkOptions& options = {}, const CallOptions& call = {}) const;

    /// How many links there are. With Hits::walls, and without with_between, from the sides of the samples alone.
    std::size_t count_links(const Grid& grid, std::span<const LinkDirection> directions,
                            const LinkOptions& options = {}, const CallOptions& call = {}) const;

    /// Where the edges of a grid between neighbouring samples meet walls: the links of (1, 0, 0), (0, 1, 0), (0, 0, 1)
    /// within the grid, from the end that is outside. Throws as links().
    Crossings crossings(const Grid& grid, const CrossingOptions& options = {}, const CallOptions& call = {},
                        TransformStatistics* statistics = nullptr) const;

    /// Where rays from origins along directions of any length meet the surface (docs/rays.md). Exact for the
    /// doubles as given: no ray slips through an edge or a vertex, and t is within 0.51 ulp.
    ///
    /// Hits::walls: where inside and outside meet, by the sign rule; a point on a wall is outside, but at the bottom of
    /// some grooves. A wall is no face within the body, nor what a ray only touches. Their number up to infinity is
    /// odd if and only if the origin is inside. Walls of the film of an open mesh, which are found to 2^-30 of the
    /// diagonal of the mesh's box, and walls and floor of the rule `below` have no triangle. Hits::faces: the places
    /// where a ray has a point of a closed triangle that it is not parallel to, also at the origin. Faces at exactly
    /// equal t are one hit.
    ///
    /// A ray whose origin is not finite, or whose direction is 0 or not finite, is not usable, nor is one that exact
    /// arithmetic cannot take: with a coordinate or a component that is not 0 but less than 2^-300 (coordinates: or
    /// more than 2^300) of 1/256 of the mesh or of the greatest component. It has t = NaN and no hits.
    /// CallOptions::log gets one warning with their number, which is TransformStatistics::unusable_points. With
    /// CallOptions::refuse_unusable_points they are refused.
    ///
    /// All arrays may be memory of the host or of the device, which is mapped.
    ///
    /// A result depends on the ray and the mesh's positions alone. Works on the host, on all cores; any number of
    /// threads may ask at once. Keeps what query() keeps. Throws Error(invalid_argument) for
    /// arrays of different lengths, too small or that overlap, for a negative limit or NaN, and without any array, and,
    /// of a restricted transform, for a ray that does not lie in one region up to its limit, with the rule `below`
    /// above the floor; Error(unsupported) for a buffer that the host may not read or write, for a mesh with a
    /// coordinate out of the range of plan_points(), for walls of a mesh without a sign and for those of a restricted
    /// one whose open edges count; Error(out_of_memory or cancelled).
    TransformStatistics rays(const InputArray& origins, const InputArray& directions, const RayOptions& options,
                             const RayTargets& targets, const CallOptions& call = {}) const;

    /// Whether the segments between pairs of points meet nothing: 1, else 0, as uint8. Hits::walls: there is no wall
    /// between the two; so the segment from a point on the surface does not meet the surface there, unless it leads
    /// into the body, and a segment in a wall does not meet it. Hits::faces: the segment, with its ends, has no point
    /// of a triangle that it is not parallel to. A pair and its reverse agree. Equal points see each other. A pair with
    /// a point that is not usable has 0. Otherwise as rays().
    TransformStatistics visible(const InputArray& from, const InputArray& to, const OutputArray& visible,
                                Hits hits = Hits::walls, const CallOptions& call = {}) const;

    // Plan.

    /// A plan of one grid, without targets: each Plan::enqueue() gets them. They must be packed and aligned. Blocks;
    /// sizes and fills every buffer. Throws Error(invalid_argument, out_of_memory, device_failure or cancelled).
    Plan plan(const Grid& grid, const Band& band, OutputSet outputs = Output::distance,
              const CallOptions& call = {}) const;

    /// A plan of boxes, as compute() has them, into buffers of the device's context, which must outlive it. Offsets and
    /// strides are multiples of a number's size. If an array is not packed or not aligned, or shares a block with other
    /// boxes, the plan computes in its own memory and copies. Also throws Error(unsupported) for other types, or for
    /// memory of the host. Messages name the request's index.
    Plan plan(std::span<const Request> requests, const CallOptions& call = {}) const;
    Plan plan(const Request& request, const CallOptions& call = {}) const { return plan(std::span(&request, 1), call); }

    /// A plan of the blocks, as requests with the same bytes, which it keeps: over 200 bytes of host memory each.
    Plan plan(const BlockSet& blocks, const CallOptions& call = {}) const;

    /// A plan for at most `count` points at a time, as query() has them, in memory of the device. Its own memory is
    /// bounded: about 200 bytes a point, of at most 2^20 points, which are computed at once. Blocks; makes every
    /// buffer.
    ///
    /// The signs are decided on the device, by sums and products of doubles that are exact while no coordinate of a
    /// vertex, unless it is 0, is smaller than 2^-300 units or greater than 2^300. A unit is the greatest power of two
    /// not above 1/256 of the longest side of the mesh's box. Other meshes are refused.
    ///
    /// Throws Error(invalid_argument) for no points or more than 2^32 - 2, for a `half_width` as query() does, and for
    /// a mesh with such a coordinate; Error(unsupported) for a restricted transform; Error(out_of_memory,
    /// device_failure, wrong_results or cancelled).
    PointPlan plan_points(std::size_t count, double half_width, OutputSet outputs = Output::distance,
                          const CallOptions& call = {}) const;

    /// A plan of the links of a grid, as links() has them, whose runs write at most `room` rows into memory of the
    /// device. Blocks; finds the links, on a GPU by kernels, and holds them: 34 bytes each, and a byte for each sample.
    /// Throws as links() does, and Error(device_failure).
    LinkPlan plan_links(const Grid& grid, std::span<const LinkDirection> directions, std::size_t room,
                        const LinkOptions& options = {}, const CallOptions& call = {}) const;

    /// The statistics().device_bytes of such a plan, which is made and given back: takes its time and its memory.
    std::size_t plan_bytes(std::span<const Request> requests, const CallOptions& call = {}) const;
    std::size_t plan_bytes(const BlockSet& blocks, const CallOptions& call = {}) const;

    /// A plan of a sparse field, whose runs have room for so many bricks and runs of bricks inside. The plan holds as
    /// many bricks' values, and a bit for each sample of the grid. Blocks; sizes and fills every buffer. Throws as
    /// compute_sparse() does.
    SparsePlan plan_sparse(const SparseRequest& request, const SparseCounts& room, const CallOptions& call = {}) const;

    // Ask.

    /// The box of the mesh's vertices in use, at their present positions; of a restricted transform, of the whole mesh.
    Box box() const;
    const Topology& topology() const;
    /// The rule in use, never `automatic`.
    SignRule sign() const;
    /// z of the floor, if the sign rule is `below`.
    std::optional<double> floor() const;
    /// The mesh's, which fields and their files have.
    std::string mesh_name() const;
    Device device() const;
    KeptMemory memory() const;
    /// Builds the programs that such a field needs and, the first time, tests them: known fields are computed and
    /// compared. Computations do it by themselves; this is for programs that want to choose when. Returns
    /// compile_seconds and first_use. Throws Error(wrong_results) that names the device, its platform and their
    /// versions if the device computes wrong values; Error(device_failure) if its compiler fails or has ended earlier
    /// processes; Error(cancelled).
    TransformStatistics compile(const Grid& grid, const Band& band, OutputSet outputs = Output::distance,
                                const CallOptions& call = {}) const;

private:
    friend class Plan;
    friend class SparsePlan;
    friend class PointPlan;
    friend class LinkPlan;
    friend struct detail::TransformAccess;
    struct State;
    explicit DistanceTransform(std::unique_ptr<State> state);
    State& state() const;
    std::unique_ptr<State> state_;
};

}  // namespace clsdf
