#pragma once
// DiskFile: a file with checked calls. A failure is a DeviceError with the file and the system's error text.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "drivers/descriptor.hpp"

namespace shaker::h5 {

/// Unit of direct I/O, bytes; offsets and addresses are multiples of it.
inline constexpr std::size_t page_bytes = 4096;
constexpr std::uint64_t whole_pages(std::uint64_t bytes) noexcept {
    return (bytes + page_bytes - 1) / page_bytes * page_bytes;
}

class DiskFile {
public:
    /// Creates an empty file; replaces an existing one.
    static DiskFile create(const std::filesystem::path& file);
    /// Opens for reading; InputError when it is missing.
    static DiskFile open(const std::filesystem::path& file);

    [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }
    [[nodiscard]] std::uint64_t size() const;
    /// Sets the length to `bytes` zeros and allocates them on the disk. The error names the folder, the space
    /// required and the space free.
    void reserve(std::uint64_t bytes);
    void write(std::uint64_t at, std::span<const std::byte> bytes);
    /// Writes whole pages at a page of the file, past the page cache: with O_DIRECT or, where the file system
    /// refuses that, through the cache with immediate write-back, dropping the pages afterwards.
    void write_pages(std::uint64_t at, std::span<const std::byte> pages);
    /// False if O_DIRECT was refused.
    [[nodiscard]] bool direct() const noexcept { return direct_; }
    /// InputError when the file is too short.
    void read(std::uint64_t at, std::span<std::byte> bytes) const;
    /// Drops this file's pages from the page cache.
    void forget() const;
    /// Returns when all written data are on the disk.
    void sync();
    /// Treatment of a file that already has the new name.
    enum class Existing { keep, replace };
    /// Renames the file and returns when the folder is on the disk. InputError, which names both files, when
    /// `to` exists and is kept.
    void rename(const std::filesystem::path& to, Existing existing);

private:
    DiskFile(std::filesystem::path path, int flags);
    [[noreturn]] void fail(const std::string& what, int error) const;
    void write_all(int to, std::uint64_t at, std::span<const std::byte> bytes);
    void push_out(std::uint64_t at, std::uint64_t bytes);

    std::filesystem::path path_;
    Descriptor fd_;
    Descriptor pages_fd_;  // second descriptor, for write_pages()
    bool direct_ = false;
    std::uint64_t last_at_ = 0, last_bytes_ = 0;  // range under write-back if O_DIRECT is refused
};

/// Returns when the directory entries of a folder are on the disk.
void sync_folder(const std::filesystem::path& folder);

/// Gives the disk back what a file holds from byte `from` on, which reads as zeros afterwards; the length
/// stays. Does nothing where the file system cannot.
void release(const std::filesystem::path& file, std::uint64_t from);

/// Replaces a file by a complete new one: a reader sees the old or the new one.
void replace_file(const std::filesystem::path& file, std::span<const std::byte> bytes);

/// Temporary name of a file until it is complete.
std::filesystem::path unfinished(const std::filesystem::path& file);

}  // namespace shaker::h5
