#include "drivers/recorded/h5/image.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <string>

#include "drivers/errors.hpp"

namespace shaker::h5 {

namespace {

const std::string what = "HDF5 file in memory";

int memory_file() {
    const int fd = ::memfd_create("h5", MFD_CLOEXEC);
    if (fd < 0) throw DeviceError{what + ": " + system_text(errno)};
    return fd;
}

// A limit of the file size (ulimit -f) holds for memory, too.
void flush(hid_t file) {
    errno = 0;
    if (H5Fflush(file, H5F_SCOPE_GLOBAL) >= 0) return;
    const int error = errno;
    throw DeviceError{what + ": " + own_words() + (error != 0 ? ": " + system_text(error) : std::string{})};
}

}  // namespace

Image::Image(hsize_t alignment) : memory_{memory_file()} {
    be_quiet();
    const Handle access{H5Pcreate(H5P_FILE_ACCESS), what};
    // Format of version 1.8: its structure has checksums, and no mark of an open file that a crash would
    // leave.
    check(H5Pset_libver_bounds(access.get(), H5F_LIBVER_V18, H5F_LIBVER_LATEST), what);
    check(H5Pset_alignment(access.get(), 1, alignment), what);
    // The default driver resolves the real path of a linked file, and this file has none.
    check(H5Pset_fapl_stdio(access.get()), what);
    const Handle create{H5Pcreate(H5P_FILE_CREATE), what};
    check(H5Pset_obj_track_times(create.get(), false), what);  // equal content gives equal bytes
    const std::string name = "/proc/self/fd/" + std::to_string(int{memory_});
    file_ = {H5Fcreate(name.c_str(), H5F_ACC_TRUNC, create.get(), access.get()), what};
}

std::uint64_t Image::size() const {
    hsize_t bytes = 0;
    flush(file_.get());
    check(H5Fget_filesize(file_.get(), &bytes), what);
    return bytes;
}

std::vector<std::byte> Image::head(std::uint64_t bytes) const {
    flush(file_.get());
    std::vector<std::byte> copy(bytes);
    std::size_t done = 0;
    while (done < copy.size()) {
        const ssize_t n = ::pread(memory_, copy.data() + done, copy.size() - done, static_cast<off_t>(done));
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) throw DeviceError{what + ": " + system_text(n < 0 ? errno : EIO)};
        done += static_cast<std::size_t>(n);
    }
    return copy;
}

}  // namespace shaker::h5
