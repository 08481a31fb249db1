#include "drivers/recorded/h5/written_file.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <new>

#include "drivers/errors.hpp"
#include "drivers/recorded/h5/file_driver.hpp"

namespace shaker::h5 {

WrittenFile::WrittenFile(int descriptor) : descriptor_{descriptor}, length_{length_of(descriptor)} {}

void WrittenFile::fail(int error) noexcept {
    if (error_ == 0) error_ = error;
}

void WrittenFile::write(std::uint64_t at, std::span<const std::byte> bytes, Kind kind) noexcept try {
    if (error_ == 0) put(at, bytes);
    length_ = std::max(length_, at + bytes.size());
    if (error_ != 0 && kind == Kind::metadata) keep(at, bytes);
} catch (const std::bad_alloc&) {
    return;  // the file has failed already
}

void WrittenFile::put(std::uint64_t at, std::span<const std::byte> bytes) noexcept {
    while (!bytes.empty()) {
        const ssize_t n = ::pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(at));
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return fail(n < 0 ? errno : EIO);
        at += static_cast<std::uint64_t>(n);
        bytes = bytes.subspan(static_cast<std::size_t>(n));
    }
}

void WrittenFile::keep(std::uint64_t at, std::span<const std::byte> bytes) {
    std::erase_if(kept_,
                  [&](const Kept& k) { return k.at >= at && k.at + k.bytes.size() <= at + bytes.size(); });
    kept_.push_back({at, {bytes.begin(), bytes.end()}});
}

bool WrittenFile::read(std::uint64_t at, std::span<std::byte> bytes) const {
    const ssize_t got = read_available(descriptor_, at, bytes.data(), bytes.size());
    if (got < 0) return false;
    std::ranges::fill(bytes.subspan(static_cast<std::size_t>(got)), std::byte{});
    for (const Kept& k : kept_) {
        const std::uint64_t from = std::max(at, k.at),
                            to = std::min(at + bytes.size(), k.at + k.bytes.size());
        if (from < to)
            std::ranges::copy(std::span{k.bytes}.subspan(from - k.at, to - from),
                              bytes.subspan(from - at).begin());
    }
    return true;
}

void WrittenFile::set_length(std::uint64_t bytes) noexcept {
    if (bytes == length_) return;
    length_ = bytes;
    while (error_ == 0 && ::ftruncate(descriptor_, static_cast<off_t>(bytes)) != 0)
        if (errno != EINTR) fail(errno);
}

void WrittenFile::sync() noexcept {
    while (error_ == 0 && ::fdatasync(descriptor_) != 0)
        if (errno != EINTR) fail(errno);
}

void WrittenFile::leave() noexcept { fail(ECANCELED); }

void WrittenFile::require_whole(const std::string& name) const {
    if (error_ != 0) throw DeviceError{name + ": " + system_text(error_)};
}

}  // namespace shaker::h5
