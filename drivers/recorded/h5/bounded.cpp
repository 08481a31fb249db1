#include "drivers/recorded/h5/bounded.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <memory>

#include "drivers/descriptor.hpp"
#include "drivers/recorded/h5/file_driver.hpp"

namespace shaker::h5 {

namespace {

/// HDF5 sees the first member only.
struct BoundedFile {
    H5FD_t common{};
    Descriptor descriptor;
    haddr_t allocated = 0;
};
static_assert(offsetof(BoundedFile, common) == 0);

BoundedFile& of(H5FD_t* file) { return *reinterpret_cast<BoundedFile*>(file); }
const BoundedFile& of(const H5FD_t* file) { return *reinterpret_cast<const BoundedFile*>(file); }

H5FD_t* open(const char* name, unsigned flags, hid_t, haddr_t) {
    if ((flags & (H5F_ACC_RDWR | H5F_ACC_TRUNC | H5F_ACC_CREAT)) != 0) {
        add_error("the file is opened for reading only", H5E_CANTOPENFILE);
        return nullptr;
    }
    auto file = std::make_unique<BoundedFile>();
    file->descriptor = Descriptor{::open(name, O_RDONLY | O_CLOEXEC)};
    if (file->descriptor < 0) {
        add_error(text_of(errno), H5E_CANTOPENFILE);
        return nullptr;
    }
    return &file.release()->common;
}

herr_t close(H5FD_t* file) {
    const std::unique_ptr<BoundedFile> closed{&of(file)};
    return 0;
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

haddr_t end(const H5FD_t* file, H5FD_mem_t) { return length_of(of(file).descriptor); }

herr_t read(H5FD_t* file, H5FD_mem_t type, hid_t, haddr_t from, size_t bytes, void* to) {
    const haddr_t size = end(file, type);
    if (from > size || bytes > size - from) {
        add_error("an address is beyond the end of the file", H5E_READERROR);
        return -1;
    }
    const ssize_t got = read_available(of(file).descriptor, from, to, bytes);
    if (got == static_cast<ssize_t>(bytes)) return 0;
    add_error(got < 0 ? text_of(errno) : "the file became shorter", H5E_READERROR);
    return -1;
}

herr_t write(H5FD_t*, H5FD_mem_t, hid_t, haddr_t, size_t, const void*) {
    add_error("the file is opened for reading only", H5E_WRITEERROR);
    return -1;
}

H5FD_class_t driver() {
    H5FD_class_t d = empty_driver("bounded");
    d.open = open;
    d.close = close;
    d.cmp = [](const H5FD_t* a, const H5FD_t* b) { return compare(of(a).descriptor, of(b).descriptor); };
    d.query = features;
    d.get_eoa = allocated;
    d.set_eoa = allocate;
    d.get_eof = end;
    d.read = read;
    d.write = write;
    d.lock = [](H5FD_t* file, hbool_t) { return lock_by_hdf5(of(file).descriptor, LOCK_SH | LOCK_NB); };
    d.unlock = [](H5FD_t* file) { return lock_by_hdf5(of(file).descriptor, LOCK_UN); };
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
