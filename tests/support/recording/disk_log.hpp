#pragma once
// What a program did to the files of a folder, call after call: written by tests/preload/disk_log.cpp, read
// by disk_images.cpp. A log is a sequence of entries: header, names, bytes.
#include <cstdint>

namespace shaker::test {

enum class DiskCall : std::uint32_t {
    create,       // name: a new file
    folder,       // name: a new folder
    rename,       // name, second name
    remove,       // name
    write,        // bytes at `at`
    size,         // `at`: the file's length from now on
    reserve,      // `at`: it is at least as long
    sync,         // returned well: what the file had `covered` entries into the log is on the disk
    sync_folder,  // likewise the names in a folder
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
