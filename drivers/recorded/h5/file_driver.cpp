#include "drivers/recorded/h5/file_driver.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <tuple>

#include "drivers/descriptor.hpp"
#include "drivers/errors.hpp"
#include "drivers/recorded/h5/written_file.hpp"

namespace shaker::h5 {

static_assert(H5_VERS_MAJOR == 1 && H5_VERS_MINOR == 10, "later versions describe a driver differently");

namespace {

struct stat status_of(int descriptor) {
    struct stat status {};
    ::fstat(descriptor, &status);
    return status;
}

/// Adds a message to HDF5's error stack. why: an H5E_ code.
void add_error(const std::string& what, hid_t why) {
    H5Epush2(H5E_DEFAULT, __FILE__, __func__, __LINE__, H5E_ERR_CLS, H5E_IO, why, "%s", what.c_str());
}

/// HDF5's order of two open files: -1, 0 (the same file) or 1.
int compare(int descriptor, int other) {
    const struct stat x = status_of(descriptor), y = status_of(other);
    const auto left = std::tie(x.st_dev, x.st_ino), right = std::tie(y.st_dev, y.st_ino);
    return left < right ? -1 : static_cast<int>(right < left);
}

/// HDF5's own advisory lock. operation: of flock(2). A file system without locks is not an error.
herr_t lock_by_hdf5(int descriptor, int operation) {
    if (::flock(descriptor, operation) == 0 || errno == ENOSYS) return 0;
    add_error(system_text(errno), H5E_CANTOPENFILE);
    return -1;
}

/// Driver without operations: limits, and the kinds of memory as HDF5's default driver has them.
H5FD_class_t empty_driver(const char* name) {
    H5FD_class_t driver{};
    driver.name = name;
    driver.maxaddr = static_cast<haddr_t>(INT64_MAX);
    driver.fc_degree = H5F_CLOSE_WEAK;
    const H5FD_mem_t kinds[H5FD_MEM_NTYPES] = H5FD_FLMAP_DICHOTOMY;
    std::memcpy(driver.fl_map, kinds, sizeof kinds);
    return driver;
}

/// HDF5 sees the first member only.
struct BoundedFile {
    H5FD_t common{};
    Descriptor descriptor;
    haddr_t allocated = 0;
};
static_assert(offsetof(BoundedFile, common) == 0);

/// HDF5's calls for reading within the bounds of a file.
struct Bounded {
    static BoundedFile& of(H5FD_t* file) { return *reinterpret_cast<BoundedFile*>(file); }
    static const BoundedFile& of(const H5FD_t* file) { return *reinterpret_cast<const BoundedFile*>(file); }

    static H5FD_t* open(const char* name, unsigned flags, hid_t, haddr_t) {
        if ((flags & (H5F_ACC_RDWR | H5F_ACC_TRUNC | H5F_ACC_CREAT)) != 0) {
            add_error("the file is opened for reading only", H5E_CANTOPENFILE);
            return nullptr;
        }
        auto file = std::make_unique<BoundedFile>();
        file->descriptor = Descriptor{::open(name, O_RDONLY | O_CLOEXEC)};
        if (file->descriptor < 0) {
            add_error(system_text(errno), H5E_CANTOPENFILE);
            return nullptr;
        }
        return &file.release()->common;
    }

    static herr_t close(H5FD_t* file) {
        const std::unique_ptr<BoundedFile> closed{&of(file)};
        return 0;
    }

    static herr_t features(const H5FD_t*, unsigned long* flags) {
        *flags = H5FD_FEAT_DATA_SIEVE | H5FD_FEAT_SUPPORTS_SWMR_IO | H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
        return 0;
    }

    static haddr_t allocated(const H5FD_t* file, H5FD_mem_t) { return of(file).allocated; }

    static herr_t allocate(H5FD_t* file, H5FD_mem_t, haddr_t end) {
        of(file).allocated = end;
        return 0;
    }

    static haddr_t end(const H5FD_t* file, H5FD_mem_t) { return length_of(of(file).descriptor); }

    static herr_t read(H5FD_t* file, H5FD_mem_t type, hid_t, haddr_t from, size_t bytes, void* to) {
        const haddr_t size = end(file, type);
        if (from > size || bytes > size - from) {
            add_error("an address is beyond the end of the file", H5E_READERROR);
            return -1;
        }
        const ssize_t got = read_available(of(file).descriptor, from, to, bytes);
        if (got == static_cast<ssize_t>(bytes)) return 0;
        add_error(got < 0 ? system_text(errno) : "the file became shorter", H5E_READERROR);
        return -1;
    }

    static herr_t write(H5FD_t*, H5FD_mem_t, hid_t, haddr_t, size_t, const void*) {
        add_error("the file is opened for reading only", H5E_WRITEERROR);
        return -1;
    }

    static H5FD_class_t driver() {
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
};

/// HDF5 sees the first member only.
struct DriverFile {
    H5FD_t common{};
    std::shared_ptr<WrittenFile> written;
    haddr_t allocated = 0;
};

/// HDF5's calls over a WrittenFile.
struct Written {
    static DriverFile& of(H5FD_t* file) { return *reinterpret_cast<DriverFile*>(file); }
    static const DriverFile& of(const H5FD_t* file) { return *reinterpret_cast<const DriverFile*>(file); }
    static int descriptor_of(const H5FD_t* file) { return of(file).written->descriptor(); }

    static H5FD_t* open(const char* name, unsigned flags, hid_t, haddr_t) {
        int how = O_CLOEXEC | ((flags & H5F_ACC_RDWR) != 0 ? O_RDWR : O_RDONLY);
        if ((flags & H5F_ACC_TRUNC) != 0) how |= O_TRUNC;
        if ((flags & H5F_ACC_CREAT) != 0) how |= O_CREAT;
        if ((flags & H5F_ACC_EXCL) != 0) how |= O_EXCL;
        constexpr mode_t mode = 0666;  // reduced by the process's umask
        const int descriptor = ::open(name, how, mode);
        if (descriptor < 0) {
            add_error("unable to open file: " + system_text(errno), H5E_CANTOPENFILE);
            return nullptr;
        }
        auto file = std::make_unique<DriverFile>();
        file->written = std::make_shared<WrittenFile>(descriptor);
        return &file.release()->common;
    }

    static herr_t close(H5FD_t* file) {
        const std::unique_ptr<DriverFile> closed{&of(file)};
        return 0;
    }

    static herr_t features(const H5FD_t*, unsigned long* flags) {
        *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
                 H5FD_FEAT_AGGREGATE_SMALLDATA | H5FD_FEAT_SUPPORTS_SWMR_IO |
                 H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
        return 0;
    }

    static haddr_t allocated(const H5FD_t* file, H5FD_mem_t) { return of(file).allocated; }

    static herr_t allocate(H5FD_t* file, H5FD_mem_t, haddr_t end) {
        of(file).allocated = end;
        return 0;
    }

    static herr_t handle(H5FD_t* file, hid_t, void** out) {
        *out = &of(file).written;
        return 0;
    }

    static herr_t read(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t from, size_t bytes, void* to) {
        if (of(file).written->read(from, {static_cast<std::byte*>(to), bytes})) return 0;
        add_error("file read failed: " + system_text(errno), H5E_READERROR);
        return -1;
    }

    static herr_t write(H5FD_t* file, H5FD_mem_t type, hid_t, haddr_t at, size_t bytes, const void* from) {
        of(file).written->write(
            at, {static_cast<const std::byte*>(from), bytes},
            type == H5FD_MEM_DRAW ? WrittenFile::Kind::data : WrittenFile::Kind::metadata);
        return 0;
    }

    static herr_t truncate(H5FD_t* file, hid_t, hbool_t) {
        of(file).written->set_length(of(file).allocated);
        return 0;
    }

    static herr_t lock(H5FD_t* file, hbool_t writes) {
        return lock_by_hdf5(descriptor_of(file), (writes ? LOCK_EX : LOCK_SH) | LOCK_NB);
    }

    static H5FD_class_t driver() {
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
};

}  // namespace

haddr_t length_of(int descriptor) { return static_cast<haddr_t>(status_of(descriptor).st_size); }

ssize_t read_available(int descriptor, haddr_t from, void* to, std::size_t bytes) {
    std::size_t done = 0;
    while (done < bytes) {
        const ssize_t got =
            ::pread(descriptor, static_cast<char*>(to) + done, bytes - done, static_cast<off_t>(from + done));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return -1;
        if (got == 0) break;
        done += static_cast<std::size_t>(got);
    }
    return static_cast<ssize_t>(done);
}

Handle bounded_access() {
    static const H5FD_class_t bounded = Bounded::driver();
    static const Handle registered{H5FDregister(&bounded), "reading within bounds"};
    Handle access{H5Pcreate(H5P_FILE_ACCESS), "property list"};
    check(H5Pset_driver(access.get(), registered.get(), nullptr), "reading within bounds");
    return access;
}

Handle written_access() {
    static const H5FD_class_t written = Written::driver();
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
