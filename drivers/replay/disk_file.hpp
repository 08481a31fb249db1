#pragma once
// A file on a disk. Every call is checked: what fails is a DeviceError with the file and the system's own
// words.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace shaker {

/// Least unit of what goes past the page cache, bytes; offsets and addresses are multiples of it.
inline constexpr std::size_t page_bytes = 4096;
constexpr std::uint64_t whole_pages(std::uint64_t bytes) noexcept {
    return (bytes + page_bytes - 1) / page_bytes * page_bytes;
}

class DiskFile {
public:
    /// A new, empty file in place of one of that name.
    static DiskFile create(const std::filesystem::path& file);
    /// For reading; InputError when it is missing.
    static DiskFile open(const std::filesystem::path& file);
    DiskFile(DiskFile&& other) noexcept;
    DiskFile& operator=(DiskFile&& other) noexcept;
    ~DiskFile();

    [[nodiscard]] const std::filesystem::path& path() const noexcept { return path_; }
    [[nodiscard]] std::uint64_t size() const;
    /// Makes the file `bytes` long, zeros, with room for all of them on the disk. The error names the folder,
    /// the room needed and what is free.
    void reserve(std::uint64_t bytes);
    void write(std::uint64_t at, std::span<const std::byte> bytes);
    /// Whole pages at a page of the file, past the page cache: with O_DIRECT or, where the file system
    /// refuses that, through the cache with write-back at once and the pages given back behind it.
    void write_pages(std::uint64_t at, std::span<const std::byte> pages);
    /// False where O_DIRECT was refused.
    [[nodiscard]] bool direct() const noexcept { return direct_; }
    /// InputError when the file ends before.
    void read(std::uint64_t at, std::span<std::byte> bytes) const;
    /// Gives what was read back to the page cache's free pages.
    void forget() const;
    /// Returns when what was written is on the disk.
    void sync();
    /// Takes the place of `to` and returns when the folder on the disk says so.
    void rename(const std::filesystem::path& to);

private:
    DiskFile(std::filesystem::path path, int flags);
    [[noreturn]] void fail(const std::string& what, int error) const;
    void write_all(int to, std::uint64_t at, std::span<const std::byte> bytes);
    void push_out(std::uint64_t at, std::uint64_t bytes);

    std::filesystem::path path_;
    int fd_ = -1;
    int pages_fd_ = -1;  // of the same file, for write_pages()
    bool direct_ = false;
    std::uint64_t last_at_ = 0, last_bytes_ = 0;  // on the way to the disk where O_DIRECT is refused
};

/// Returns when the names in a folder are on the disk.
void sync_folder(const std::filesystem::path& folder);

/// Puts a complete file in the place of another: whoever opens `file` sees the old or the new one.
void replace_file(const std::filesystem::path& file, std::span<const std::byte> bytes);

/// The name under which a file is made before it takes its place.
std::filesystem::path unfinished(const std::filesystem::path& file);

}  // namespace shaker
