#include "drivers/recorded/h5/bounded.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <tuple>

namespace shaker::h5 {

namespace {

static_assert(H5_VERS_MAJOR == 1 && H5_VERS_MINOR == 10, "later versions describe a driver differently");

/// HDF5 sees the first member only.
struct BoundedFile {
    H5FD_t common{};
    int descriptor = -1;
    haddr_t allocated = 0;

    ~BoundedFile() {
        if (descriptor >= 0) ::close(descriptor);
    }
};
static_assert(offsetof(BoundedFile, common) == 0);

BoundedFile& of(H5FD_t* file) { return *reinterpret_cast<BoundedFile*>(file); }
const BoundedFile& of(const H5FD_t* file) { return *reinterpret_cast<const BoundedFile*>(file); }

void say(const char* what, hid_t why) {
    H5Epush2(H5E_DEFAULT, __FILE__, __func__, __LINE__, H5E_ERR_CLS, H5E_IO, why, "%s", what);
}

struct stat status_of(const H5FD_t* file) {
    struct stat status {};
    ::fstat(of(file).descriptor, &status);
    return status;
}

H5FD_t* open(const char* name, unsigned flags, hid_t, haddr_t) {
    if ((flags & (H5F_ACC_RDWR | H5F_ACC_TRUNC | H5F_ACC_CREAT)) != 0) {
        say("the file is opened for reading only", H5E_CANTOPENFILE);
        return nullptr;
    }
    auto file = std::make_unique<BoundedFile>();
    file->descriptor = ::open(name, O_RDONLY | O_CLOEXEC);
    if (file->descriptor < 0) {
        say(std::strerror(errno), H5E_CANTOPENFILE);
        return nullptr;
    }
    return &file.release()->common;
}

herr_t close(H5FD_t* file) {
    const std::unique_ptr<BoundedFile> closed{&of(file)};
    return 0;
}

int compare(const H5FD_t* a, const H5FD_t* b) {
    const struct stat x = status_of(a), y = status_of(b);
    const auto left = std::tie(x.st_dev, x.st_ino), right = std::tie(y.st_dev, y.st_ino);
    return left < right ? -1 : static_cast<int>(right < left);
}

herr_t features(const H5FD_t*, unsigned long* flags) {
    *flags = H5FD_FEAT_DATA_SIEVE | H5FD_FEAT_SUPPORTS_SWMR_IO | H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
    return 0;
}

haddr_t allocated(const H5FD_t* file, H5FD_mem_t) { return of(file).allocated; }

herr_t allocate(H5FD_t* file, H5FD_mem_t, haddr_t end) {
    of(file).allocated = end;
    return 0;
}

haddr_t end(const H5FD_t* file, H5FD_mem_t) { return static_cast<haddr_t>(status_of(file).st_size); }

herr_t read(H5FD_t* file, H5FD_mem_t type, hid_t, haddr_t from, size_t bytes, void* to) {
    const haddr_t size = end(file, type);
    if (from > size || bytes > size - from) {
        say("an address is beyond the end of the file", H5E_READERROR);
        return -1;
    }
    for (auto* at = static_cast<char*>(to); bytes > 0;) {
        const ssize_t got = ::pread(of(file).descriptor, at, bytes, static_cast<off_t>(from));
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) {
            say(got == 0 ? "the file became shorter" : std::strerror(errno), H5E_READERROR);
            return -1;
        }
        at += got;
        from += static_cast<haddr_t>(got);
        bytes -= static_cast<size_t>(got);
    }
    return 0;
}

herr_t write(H5FD_t*, H5FD_mem_t, hid_t, haddr_t, size_t, const void*) {
    say("the file is opened for reading only", H5E_WRITEERROR);
    return -1;
}

herr_t flock_to(const H5FD_t* file, int operation) {
    // On file systems without locks the file is read without a lock.
    if (::flock(of(file).descriptor, operation) == 0 || errno == ENOSYS) return 0;
    say(std::strerror(errno), H5E_CANTOPENFILE);
    return -1;
}

H5FD_class_t driver() {
    H5FD_class_t d{};
    d.name = "bounded";
    d.maxaddr = static_cast<haddr_t>(INT64_MAX);
    d.fc_degree = H5F_CLOSE_WEAK;
    d.open = open;
    d.close = close;
    d.cmp = compare;
    d.query = features;
    d.get_eoa = allocated;
    d.set_eoa = allocate;
    d.get_eof = end;
    d.read = read;
    d.write = write;
    d.lock = [](H5FD_t* file, hbool_t) { return flock_to(file, LOCK_SH | LOCK_NB); };
    d.unlock = [](H5FD_t* file) { return flock_to(file, LOCK_UN); };
    const H5FD_mem_t kinds[H5FD_MEM_NTYPES] = H5FD_FLMAP_DICHOTOMY;
    std::memcpy(d.fl_map, kinds, sizeof kinds);
    return d;
}

}  // namespace

Handle bounded_access() {
    static const H5FD_class_t bounded = driver();
    static const Handle registered{H5FDregister(&bounded), "reading within bounds"};
    Handle access{H5Pcreate(H5P_FILE_ACCESS), "property list"};
    check(H5Pset_driver(access.get(), registered.get(), nullptr), "reading within bounds");
    return access;
}

}  // namespace shaker::h5
