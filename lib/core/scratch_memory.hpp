#pragma once

#include <cstddef>
#include <vector>

namespace clsdf {

/// Keeps the memory of large arrays that are given back, for the next computation of the same kind: fresh pages cost
/// more than what is done with them. For one thread at a time.
class ScratchMemory {
public:
    ScratchMemory() = default;
    ScratchMemory(const ScratchMemory&) = delete;
    ScratchMemory& operator=(const ScratchMemory&) = delete;
    ~ScratchMemory();

    /// large_memory_bytes or more. Throws std::bad_alloc.
    void* allocate(std::size_t bytes);
    void give_back(void* memory) noexcept;

    /// Releases what was not in use since the last call.
    void trim() noexcept;

    /// Releases all that is not in use.
    void release() noexcept;

    /// In use or kept.
    std::size_t bytes() const;

    /// Around a computation: keeps what it used where it succeeded, and so did the one before: those who compute once
    /// keep nothing. Else releases everything.
    class Computation {
    public:
        explicit Computation(ScratchMemory& scratch) : scratch_(scratch) {}
        Computation(const Computation&) = delete;
        Computation& operator=(const Computation&) = delete;
        ~Computation();

        void succeed() { has_succeeded_ = true; }

    private:
        ScratchMemory& scratch_;
        bool has_succeeded_ = false;
    };

private:
    template <class Predicate>
    void free_unless(const Predicate& is_needed) noexcept;

    struct Block {
        void* memory = nullptr;
        std::size_t bytes = 0;
        bool is_taken = false;
        bool was_taken = false;  // since the last trim()
    };

    std::vector<Block> blocks_;
    bool is_repeated_ = false;  // a computation has succeeded before
};

}  // namespace clsdf
