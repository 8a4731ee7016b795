#pragma once

#include "scratch_watcher.hpp"

#include "core/files.hpp"

#include <cstddef>
#include <string>

/// Large arrays in files of a scratch folder, so that together they may be larger than the memory.
///
/// While an object lives, operator new makes each block of `least_block` bytes and more a mapping of a file of its own,
/// whose disk space is reserved at once. The files have no names: none stays, however the process ends. A thread keeps
/// what is resident of the process within `memory` bytes: it writes pages that were not used lately to their files and
/// takes them out of the memory. While it cannot do that as fast as others use new pages, they wait. The contents of
/// blocks are those of other memory. Blocks that outlive the object stay what they are.
///
/// Memory that libraries take from malloc stays in memory. In builds with sanitizers, which have operators of their
/// own, nothing goes to files. One object at a time.
class ScratchMemory {
public:
    static constexpr std::size_t usual_least_block = std::size_t{1} << 20;

    /// memory: the limit; it may be smaller than what cannot leave the memory, which then stays. Throws
    /// clsdf::Error(invalid_argument or unsupported) that names the folder if it is none, cannot be written to, lies in
    /// memory, or is one of another machine.
    ScratchMemory(const std::string& folder, std::size_t memory, std::size_t least_block = usual_least_block);
    ~ScratchMemory();
    ScratchMemory(const ScratchMemory&) = delete;
    ScratchMemory& operator=(const ScratchMemory&) = delete;

    /// Throws clsdf::Error(output_failure) if the folder had no room for a block, for which operator new has thrown
    /// std::bad_alloc.
    void throw_if_full() const;

    struct Use {
        std::size_t most_bytes = 0;     ///< of all blocks at once
        std::size_t most_resident = 0;  ///< of the process, and of pages of its blocks that are on their way to disk
        std::size_t blocks = 0;         ///< that there were
        std::size_t missed = 0;         ///< bytes of arrays that stayed in memory, for lack of files
        double waited = 0;              ///< seconds in which all threads waited for the disk
    };
    Use use() const;

private:
    std::string folder_;
    clsdf::Descriptor opened_;
    ScratchWatcher watcher_;
};
