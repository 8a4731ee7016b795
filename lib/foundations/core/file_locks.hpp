#pragma once

namespace clsdf {

/// Whether the open file or folder is on a file system of this machine alone that is known to support locks: ext2 to
/// ext4, XFS, Btrfs, F2FS, ZFS, bcachefs, tmpfs and overlays. On a file system that several machines share, a lock may
/// cover this machine's processes only, and may wait for a server.
bool is_of_one_machine(int descriptor);

/// Locks the open file (flock) unless another holder has it. The lock ends when the last copy of the descriptor does.
bool try_to_lock(int descriptor);

}  // namespace clsdf
