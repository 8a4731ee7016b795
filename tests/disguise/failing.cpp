#include "disguise/failing.hpp"

#include <algorithm>
#include <atomic>
#include <map>
#include <set>
#include <span>

namespace clsdf::disguise {

namespace {

constexpr cl_int status_behind = -1;  // as PoCL's

struct Failing {
    std::mutex mutex;
    std::set<cl_command_queue> queues;            ///< the host has not waited since a kernel has failed
    std::map<cl_event, cl_command_queue> events;  ///< that have failed; each is retained for good
    std::atomic<bool> has_failed = false;
};
Failing& failing() {
    static auto* const only = new Failing;
    return *only;
}

/// Under the mutex.
cl_int fail(cl_command_queue queue, cl_int status, cl_event* event) {
    if (event == nullptr) return CL_SUCCESS;
    cl_context context = nullptr;
    cl_int code = CLSDF_NEXT(clGetCommandQueueInfo)(queue, CL_QUEUE_CONTEXT, sizeof context, &context, nullptr);
    if (code != CL_SUCCESS) return code;
    *event = CLSDF_NEXT(clCreateUserEvent)(context, &code);
    if (code != CL_SUCCESS) return code;
    CLSDF_NEXT(clRetainEvent)(*event);
    failing().events.emplace(*event, queue);
    return CLSDF_NEXT(clSetUserEventStatus)(*event, status);
}

}  // namespace

cl_int fail_kernel(cl_command_queue queue, cl_int status, cl_event* event) {
    const std::scoped_lock lock(failing().mutex);
    failing().has_failed = true;
    failing().queues.insert(queue);
    return fail(queue, status, event);
}

bool is_failing(cl_command_queue queue, cl_uint waits, const cl_event* wait_list) {
    if (!failing().has_failed) return false;
    const std::scoped_lock lock(failing().mutex);
    return failing().queues.contains(queue) || std::ranges::any_of(std::span(wait_list, waits), [](cl_event event) {
               return failing().events.contains(event);
           });
}

cl_int fail_command(cl_command_queue queue, bool is_blocking, cl_event* event) {
    const std::scoped_lock lock(failing().mutex);
    const cl_int code = fail(queue, status_behind, event);
    if (is_blocking) failing().queues.erase(queue);
    return code;
}

void end_failing(cl_command_queue queue) {
    if (!failing().has_failed) return;
    const std::scoped_lock lock(failing().mutex);
    failing().queues.erase(queue);
}

void end_failing(cl_uint events, const cl_event* list) {
    if (!failing().has_failed) return;
    const std::scoped_lock lock(failing().mutex);
    for (const cl_event event : std::span(list, events))
        if (const auto failed = failing().events.find(event); failed != failing().events.end())
            failing().queues.erase(failed->second);
}

}  // namespace clsdf::disguise
