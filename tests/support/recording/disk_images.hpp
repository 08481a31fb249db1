#pragma once
// Possible contents of a disk after a power cut, rebuilt from the log of a program's file operations.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "tests/support/recording/disk_log.hpp"

namespace shaker::test {

/// The part of the unsynced data that is on the disk nevertheless.
enum class Surviving {
    all,    // only the program died
    half,   // a random half of the pages, each in a state after the sync; names up to a random time
    synced  // nothing
};
const char* name(Surviving surviving) noexcept;

class DiskImages {
public:
    /// Reads a log by tests/preload/disk_log.cpp for `folder`. std::runtime_error for other files.
    DiskImages(const std::filesystem::path& log, std::filesystem::path folder);
    ~DiskImages();
    DiskImages(const DiskImages&) = delete;
    DiskImages& operator=(const DiskImages&) = delete;

    /// Number of calls in the log. A cut is given by the number of calls before it.
    [[nodiscard]] std::size_t size() const noexcept { return calls_.size(); }
    /// Cuts directly after a sync of the file that has this name at that time, in their order.
    [[nodiscard]] std::vector<std::size_t> syncs(const std::string& file_name) const;
    /// Makes an image in an empty folder.
    void build(const std::filesystem::path& into, std::size_t cut, Surviving surviving,
               std::uint64_t seed) const;

private:
    struct Call {
        DiskEntry entry;  // file: a number that no other file has, from 1
        std::string name, second;
        std::span<const std::byte> bytes;
    };
    using Names = std::map<std::string, std::uint64_t>;  // a file's number; 0: a folder

    void read(std::span<const std::byte> log);
    [[nodiscard]] std::vector<std::size_t> names_kept(std::size_t cut, Surviving surviving,
                                                      std::mt19937_64& random) const;
    [[nodiscard]] Names names_after(const std::vector<std::size_t>& kept) const;
    void build_file(const std::filesystem::path& file, std::uint64_t number, std::size_t cut,
                    Surviving surviving, std::mt19937_64& random) const;

    std::filesystem::path folder_;
    std::vector<Call> calls_;
    std::span<const std::byte> mapped_;
};

}  // namespace shaker::test
