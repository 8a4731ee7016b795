// Particles in the caller's device memory bounce off a solid for 100 steps. The host enqueues all steps and waits once.
//
// A plan of points allocates everything once. Then PointPlan::enqueue() puts the search for all particles into the
// caller's queue, between the caller's own kernels: nothing comes to the host. Positions, distances and gradients are
// members of the particles.

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <clsdf/clsdf.hpp>

#include "recorded.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <random>
#include <vector>

namespace {

void require(cl_int status, const char* call) {
    if (status == CL_SUCCESS) return;
    std::fprintf(stderr, "%s failed: OpenCL error %d\n", call, status);
    std::exit(2);
}

constexpr std::size_t particle_count = 20'000;
constexpr int step_count = 100;
constexpr double step_length = 0.02;  // that a particle moves in a step

struct Particle {
    clsdf::Vec3 position{};
    clsdf::Vec3 direction{};
    std::array<float, 3> gradient{};
    float distance = 0;
    std::uint32_t bounces = 0;
    std::uint8_t status = 0;
    std::array<std::uint8_t, 3> padding{};
};
static_assert(sizeof(Particle) == 72);

constexpr const char* motion = R"(
#pragma OPENCL EXTENSION cl_khr_fp64 : enable

typedef struct Particle {
    double position[3], direction[3];
    float gradient[3], distance;
    uint bounces;
    uchar status, padding[3];
} Particle;

// A particle nearer than a step that comes closer is reflected. Then all move.
__kernel void move(__global Particle* particles, uint count, double length) {
    const uint i = get_global_id(0);
    if (i >= count) return;
    Particle p = particles[i];
    double towards = 0;
    for (int axis = 0; axis < 3; ++axis) towards += p.direction[axis] * p.gradient[axis];
    if (p.distance < length && towards < 0) {
        for (int axis = 0; axis < 3; ++axis) p.direction[axis] -= 2 * towards * p.gradient[axis];
        ++p.bounces;
    }
    for (int axis = 0; axis < 3; ++axis) p.position[axis] += length * p.direction[axis];
    particles[i] = p;
}
)";

/// On a sphere around the solid, towards a place near its middle.
std::vector<Particle> particles_around() {
    std::mt19937 random(5);
    const auto number = [&] { return 2 * (static_cast<double>(random()) / std::mt19937::max()) - 1; };
    std::vector<Particle> particles(particle_count);
    for (Particle& p : particles) {
        clsdf::Vec3 aim{};
        double length = 0, distance = 0;
        for (double& x : p.position) length = std::hypot(length, x = number());
        for (std::size_t axis = 0; axis < 3; ++axis) {
            p.position[axis] *= 1.5 / length;
            aim[axis] = 0.3 * number() - p.position[axis];
            distance = std::hypot(distance, aim[axis]);
        }
        for (std::size_t axis = 0; axis < 3; ++axis) p.direction[axis] = aim[axis] / distance;
    }
    return particles;
}

template <class Array>
Array in_particles(cl_mem memory, clsdf::ElementType type, std::size_t offset) {
    Array array;
    array.device = memory;
    array.type = type;
    array.offset = offset;
    array.strides[0] = sizeof(Particle);
    return array;
}

/// Moves the particles on the device. The last search is for the places where they end.
std::vector<Particle> moved(const clsdf::DistanceTransform& transform, cl_context context, cl_device_id device,
                            cl_command_queue queue) {
    using clsdf::ElementType;
    cl_int status = CL_SUCCESS;
    const char* text = motion;
    cl_program program = clCreateProgramWithSource(context, 1, &text, nullptr, &status);
    require(status, "clCreateProgramWithSource");
    require(clBuildProgram(program, 1, &device, "-cl-std=CL1.2", nullptr, nullptr), "clBuildProgram");
    cl_kernel move = clCreateKernel(program, "move", &status);
    require(status, "clCreateKernel");
    std::vector<Particle> particles = particles_around();
    cl_mem memory = clCreateBuffer(context, CL_MEM_READ_WRITE | CL_MEM_COPY_HOST_PTR,
                                   particles.size() * sizeof(Particle), particles.data(), &status);
    require(status, "clCreateBuffer");

    auto points = in_particles<clsdf::InputArray>(memory, ElementType::float64, offsetof(Particle, position));
    points.count = particle_count;
    const auto output = [&](ElementType type, std::size_t offset) {
        return in_particles<clsdf::OutputArray>(memory, type, offset);
    };
    const clsdf::OutputTargets targets{
        {clsdf::Output::distance, output(ElementType::float32, offsetof(Particle, distance))},
        {clsdf::Output::gradient, output(ElementType::float32, offsetof(Particle, gradient))}};
    const clsdf::OutputArray states = output(ElementType::uint8, offsetof(Particle, status));

    // plan_points() may block and allocate. The runs do neither, and the queue is in order.
    clsdf::PointPlan plan =
        transform.plan_points(particle_count, std::numeric_limits<double>::infinity(), clsdf::Output::gradient);
    const auto count = static_cast<cl_uint>(particle_count);
    const std::size_t items = particle_count;
    require(clSetKernelArg(move, 0, sizeof memory, &memory), "clSetKernelArg");
    require(clSetKernelArg(move, 1, sizeof count, &count), "clSetKernelArg");
    require(clSetKernelArg(move, 2, sizeof step_length, &step_length), "clSetKernelArg");
    for (int step = 0; step < step_count; ++step) {
        plan.enqueue(queue, points, targets);
        require(clEnqueueNDRangeKernel(queue, move, 1, nullptr, &items, nullptr, 0, nullptr, nullptr),
                "clEnqueueNDRangeKernel");
    }
    plan.enqueue(queue, points, targets, {}, nullptr, states);
    require(clEnqueueReadBuffer(queue, memory, CL_TRUE, 0, particles.size() * sizeof(Particle), particles.data(), 0,
                                nullptr, nullptr),
            "clEnqueueReadBuffer");
    clReleaseMemObject(memory);
    clReleaseKernel(move);
    clReleaseProgram(program);
    return particles;
}

}  // namespace

int main() {
    try {
        const clsdf::Device device = clsdf::Device::automatic();
        const clsdf::Mesh mesh = clsdf::make_shape("knot");
        const clsdf::DistanceTransform transform(device, mesh);
        const std::vector<Particle> particles = moved(transform, device.context(), device.id(), device.queue());

        // The same distances by a query of the host.
        std::vector<clsdf::Vec3> positions;
        for (const Particle& p : particles) positions.push_back(p.position);
        std::vector<float> expected(particles.size());
        transform.query(positions, std::numeric_limits<double>::infinity(), expected);
        std::size_t bounces = 0, different = 0, inside = 0;
        for (std::size_t i = 0; i < particles.size(); ++i) {
            const Particle& p = particles[i];
            bounces += p.bounces;
            different += p.distance != expected[i] || p.status != 0;
            inside += p.distance < 0;
        }
        record(std::array{static_cast<double>(different), static_cast<double>(inside)});
        std::printf(
            "%zu particles on %s: %zu bounces in %d steps, %zu are inside, %zu have another distance by query()\n",
            particles.size(), device.name().c_str(), bounces, step_count, inside, different);
        const bool right = bounces > particle_count / 10 && inside == 0 && different == 0;
        std::puts(right ? "as it should be" : "WRONG");
        return right ? 0 : 1;
    } catch (const clsdf::Error& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 2;
    }
}
