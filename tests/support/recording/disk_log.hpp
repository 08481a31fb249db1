#pragma once
// Log of a program's calls that change the files of a folder. tests/preload/disk_log.cpp writes it,
// disk_images.cpp reads it. A log is a sequence of entries: header, names, bytes.
#include <cstdint>

namespace shaker::test {

enum class DiskCall : std::uint32_t {
    create,       // name: a new file
    folder,       // name: a new folder
    rename,       // name, second name
    remove,       // name
    write,        // bytes at `at`
    size,         // `at`: new length of the file
    reserve,      // `at`: new minimum length of the file
    sync,         // successful: the file's content after `covered` entries of the log is on the disk
    sync_folder,  // successful: the names in a folder after `covered` entries are on the disk
};

struct DiskEntry {
    DiskCall call;
    std::uint32_t name_bytes, second_bytes;
    std::uint32_t padding;
    std::uint64_t file;  // its inode
    std::int64_t at;
    std::uint64_t covered;
    std::uint64_t bytes;
};

}  // namespace shaker::test
