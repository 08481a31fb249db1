#pragma once
// WrittenFile: the file on the disk that HDF5 writes. The first failed call ends all changes of it.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/descriptor.hpp"
#include "drivers/recorded/h5/h5.hpp"

namespace shaker::h5 {

/// HDF5 1.10 does not survive a file that it cannot write: closing it fails, the file stays open, and later
/// calls use freed memory. Therefore no failure of the disk is reported to HDF5. The first one is kept for
/// the writer, which asks for it; the file stays as it was then, that of a killed program. Metadata that HDF5
/// writes later are kept in memory, because HDF5 may read them again; later data are lost.
/// One thread at a time.
class WrittenFile {
public:
    /// Takes ownership of a descriptor that is open for reading and writing.
    explicit WrittenFile(int descriptor);

    enum class Kind { data, metadata };
    void write(std::uint64_t at, std::span<const std::byte> bytes, Kind kind) noexcept;
    /// Bytes beyond the end are 0. False when the disk fails; sets errno.
    [[nodiscard]] bool read(std::uint64_t at, std::span<std::byte> bytes) const;
    void set_length(std::uint64_t bytes) noexcept;
    /// Returns when all that was written is on the disk, or has failed.
    void sync() noexcept;
    /// The file on the disk does not change any more.
    void leave() noexcept;

    /// Bytes, as if no call had failed.
    [[nodiscard]] std::uint64_t length() const noexcept { return length_; }
    [[nodiscard]] int descriptor() const noexcept { return descriptor_; }
    /// DeviceError with `name` and the system's text for the first failed call, if there was one.
    void require_whole(const std::string& name) const;

private:
    struct Kept {
        std::uint64_t at;
        std::vector<std::byte> bytes;
    };
    void put(std::uint64_t at, std::span<const std::byte> bytes) noexcept;
    void keep(std::uint64_t at, std::span<const std::byte> bytes);
    void fail(int error) noexcept;

    Descriptor descriptor_;
    int error_ = 0;  // errno of the first failed call; 0: none
    std::uint64_t length_;
    std::vector<Kept> kept_;  // a later one replaces bytes of an earlier one
};

/// File access properties for H5Fcreate and H5Fopen: HDF5's default driver over a WrittenFile.
Handle written_access();
/// The file of an identifier that was opened with written_access(). It may outlive the identifier.
std::shared_ptr<WrittenFile> written_file(hid_t file);

}  // namespace shaker::h5
