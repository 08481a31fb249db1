// HDF5's file driver over a WrittenFile.
#include <fcntl.h>
#include <sys/file.h>

#include <cerrno>

#include "drivers/recorded/h5/file_driver.hpp"
#include "drivers/recorded/h5/written_file.hpp"

namespace shaker::h5 {

namespace {

/// HDF5 sees the first member only.
struct DriverFile {
    H5FD_t common{};
    std::shared_ptr<WrittenFile> written;
    haddr_t allocated = 0;
};

DriverFile& of(H5FD_t* file) { return *reinterpret_cast<DriverFile*>(file); }
const DriverFile& of(const H5FD_t* file) { return *reinterpret_cast<const DriverFile*>(file); }
int descriptor_of(const H5FD_t* file) { return of(file).written->descriptor(); }

H5FD_t* open(const char* name, unsigned flags, hid_t, haddr_t) {
    int how = O_CLOEXEC | ((flags & H5F_ACC_RDWR) != 0 ? O_RDWR : O_RDONLY);
    if ((flags & H5F_ACC_TRUNC) != 0) how |= O_TRUNC;
    if ((flags & H5F_ACC_CREAT) != 0) how |= O_CREAT;
    if ((flags & H5F_ACC_EXCL) != 0) how |= O_EXCL;
    constexpr mode_t mode = 0666;  // reduced by the process's umask
    const int descriptor = ::open(name, how, mode);
    if (descriptor < 0) {
        add_error("unable to open file: " + text_of(errno), H5E_CANTOPENFILE);
        return nullptr;
    }
    auto file = std::make_unique<DriverFile>();
    file->written = std::make_shared<WrittenFile>(descriptor);
    return &file.release()->common;
}

herr_t close(H5FD_t* file) {
    const std::unique_ptr<DriverFile> closed{&of(file)};
    return 0;
}

herr_t features(const H5FD_t*, unsigned long* flags) {
    *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
             H5FD_FEAT_AGGREGATE_SMALLDATA | H5FD_FEAT_SUPPORTS_SWMR_IO | H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
    return 0;
}

haddr_t allocated(const H5FD_t* file, H5FD_mem_t) { return of(file).allocated; }

herr_t allocate(H5FD_t* file, H5FD_mem_t, haddr_t end) {
    of(file).allocated = end;
    return 0;
}

herr_t handle(H5FD_t* file, hid_t, void** out) {
    *out = &of(file).written;
    return 0;
}

herr_t read(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t from, size_t bytes, void* to) {
    if (of(file).written->read(from, {static_cast<std::byte*>(to), bytes})) return 0;
    add_error("file read failed: " + text_of(errno), H5E_READERROR);
    return -1;
}

herr_t write(H5FD_t* file, H5FD_mem_t type, hid_t, haddr_t at, size_t bytes, const void* from) {
    of(file).written->write(at, {static_cast<const std::byte*>(from), bytes},
                            type == H5FD_MEM_DRAW ? WrittenFile::Kind::data : WrittenFile::Kind::metadata);
    return 0;
}

herr_t truncate(H5FD_t* file, hid_t, hbool_t) {
    of(file).written->set_length(of(file).allocated);
    return 0;
}

herr_t lock(H5FD_t* file, hbool_t writes) {
    return lock_by_hdf5(descriptor_of(file), (writes ? LOCK_EX : LOCK_SH) | LOCK_NB);
}

H5FD_class_t driver() {
    H5FD_class_t d = empty_driver("written");
    d.open = open;
    d.close = close;
    d.cmp = [](const H5FD_t* a, const H5FD_t* b) { return compare(descriptor_of(a), descriptor_of(b)); };
    d.query = features;
    d.get_eoa = allocated;
    d.set_eoa = allocate;
    d.get_eof = [](const H5FD_t* file, H5FD_mem_t) -> haddr_t { return of(file).written->length(); };
    d.get_handle = handle;
    d.read = read;
    d.write = write;
    d.truncate = truncate;
    d.lock = lock;
    d.unlock = [](H5FD_t* file) { return lock_by_hdf5(descriptor_of(file), LOCK_UN); };
    return d;
}

}  // namespace

Handle written_access() {
    static const H5FD_class_t written = driver();
    static const Handle registered{H5FDregister(&written), "writing"};
    Handle access{H5Pcreate(H5P_FILE_ACCESS), "property list"};
    check(H5Pset_driver(access.get(), registered.get(), nullptr), "writing");
    return access;
}

std::shared_ptr<WrittenFile> written_file(hid_t file) {
    void* found = nullptr;
    check(H5Fget_vfd_handle(file, H5P_DEFAULT, &found), "file driver");
    return *static_cast<std::shared_ptr<WrittenFile>*>(found);
}

}  // namespace shaker::h5
