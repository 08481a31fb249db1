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

/// HDF5's own advisory lock. operation: of flock(2). A file system without locks is not an error.
herr_t lock_by_hdf5(int descriptor, int operation) {
    if (::flock(descriptor, operation) == 0 || errno == ENOSYS) return 0;
    add_error(system_text(errno), H5E_CANTOPENFILE);
    return -1;
}

/// The calls of HDF5 that are the same for both drivers.
template <class File>
struct Common {
    static_assert(offsetof(File, common) == 0);  // HDF5 sees this member only
    static File& of(H5FD_t* file) { return *reinterpret_cast<File*>(file); }
    static const File& of(const H5FD_t* file) { return *reinterpret_cast<const File*>(file); }

    static herr_t close(H5FD_t* file) {
        const std::unique_ptr<File> closed{&of(file)};
        return 0;
    }

    /// HDF5's order of two open files: -1, 0 (the same file) or 1.
    static int compare(const H5FD_t* a, const H5FD_t* b) {
        const struct stat x = status_of(of(a).descriptor()), y = status_of(of(b).descriptor());
        const auto left = std::tie(x.st_dev, x.st_ino), right = std::tie(y.st_dev, y.st_ino);
        return left < right ? -1 : static_cast<int>(right < left);
    }

    static haddr_t allocated(const H5FD_t* file, H5FD_mem_t) { return of(file).allocated; }

    static herr_t allocate(H5FD_t* file, H5FD_mem_t, haddr_t end) {
        of(file).allocated = end;
        return 0;
    }

    static herr_t lock(H5FD_t* file, hbool_t writes) {
        return lock_by_hdf5(of(file).descriptor(), (writes ? LOCK_EX : LOCK_SH) | LOCK_NB);
    }

    static herr_t unlock(H5FD_t* file) { return lock_by_hdf5(of(file).descriptor(), LOCK_UN); }
};

/// A driver with these calls; the kinds of memory are those of HDF5's default driver.
template <class Calls>
H5FD_class_t driver_of(const char* name) {
    H5FD_class_t d{};
    d.name = name;
    d.maxaddr = static_cast<haddr_t>(INT64_MAX);
    d.fc_degree = H5F_CLOSE_WEAK;
    const H5FD_mem_t kinds[H5FD_MEM_NTYPES] = H5FD_FLMAP_DICHOTOMY;
    std::memcpy(d.fl_map, kinds, sizeof kinds);
    d.open = Calls::open;
    d.close = Calls::close;
    d.cmp = Calls::compare;
    d.query = [](const H5FD_t*, unsigned long* flags) -> herr_t {
        *flags = Calls::features;
        return 0;
    };
    d.get_eoa = Calls::allocated;
    d.set_eoa = Calls::allocate;
    d.get_eof = Calls::end;
    d.read = Calls::read;
    d.write = Calls::write;
    d.lock = Calls::lock;
    d.unlock = Calls::unlock;
    return d;
}

struct BoundedFile {
    H5FD_t common{};
    Descriptor opened;
    haddr_t allocated = 0;
    [[nodiscard]] int descriptor() const { return opened; }
};

/// HDF5's calls for reading within the bounds of a file.
struct Bounded : Common<BoundedFile> {
    static constexpr unsigned long features =
        H5FD_FEAT_DATA_SIEVE | H5FD_FEAT_SUPPORTS_SWMR_IO | H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
    static H5FD_class_t driver() { return driver_of<Bounded>("bounded"); }

    static H5FD_t* open(const char* name, unsigned flags, hid_t, haddr_t) {
        if ((flags & (H5F_ACC_RDWR | H5F_ACC_TRUNC | H5F_ACC_CREAT)) != 0) {
            add_error("the file is opened for reading only", H5E_CANTOPENFILE);
            return nullptr;
        }
        auto file = std::make_unique<BoundedFile>();
        file->opened = Descriptor{::open(name, O_RDONLY | O_CLOEXEC)};
        if (file->opened < 0) {
            add_error(system_text(errno), H5E_CANTOPENFILE);
            return nullptr;
        }
        return &file.release()->common;
    }

    static haddr_t end(const H5FD_t* file, H5FD_mem_t) { return length_of(of(file).descriptor()); }

    static herr_t read(H5FD_t* file, H5FD_mem_t type, hid_t, haddr_t from, size_t bytes, void* to) {
        const haddr_t size = end(file, type);
        if (from > size || bytes > size - from) {
            add_error("an address is beyond the end of the file", H5E_READERROR);
            return -1;
        }
        const ssize_t got = read_available(of(file).descriptor(), from, to, bytes);
        if (got == static_cast<ssize_t>(bytes)) return 0;
        add_error(got < 0 ? system_text(errno) : "the file became shorter", H5E_READERROR);
        return -1;
    }

    static herr_t write(H5FD_t*, H5FD_mem_t, hid_t, haddr_t, size_t, const void*) {
        add_error("the file is opened for reading only", H5E_WRITEERROR);
        return -1;
    }
};

struct DriverFile {
    H5FD_t common{};
    std::shared_ptr<WrittenFile> written;
    haddr_t allocated = 0;
    [[nodiscard]] int descriptor() const { return written->descriptor(); }
};

/// HDF5's calls over a WrittenFile.
struct Written : Common<DriverFile> {
    static constexpr unsigned long features = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA |
                                              H5FD_FEAT_DATA_SIEVE | H5FD_FEAT_AGGREGATE_SMALLDATA |
                                              H5FD_FEAT_SUPPORTS_SWMR_IO | H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;

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

    static haddr_t end(const H5FD_t* file, H5FD_mem_t) { return of(file).written->length(); }

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

    static H5FD_class_t driver() {
        H5FD_class_t d = driver_of<Written>("written");
        d.get_handle = handle;
        d.truncate = truncate;
        return d;
    }
};

/// Access to files by a driver. what: begins the text of an error.
template <class Calls>
Handle access_by(const char* what) {
    static const H5FD_class_t driver = Calls::driver();
    static const Handle registered{H5FDregister(&driver), what};
    Handle access{H5Pcreate(H5P_FILE_ACCESS), "property list"};
    check(H5Pset_driver(access.get(), registered.get(), nullptr), what);
    return access;
}

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

Handle bounded_access() { return access_by<Bounded>("reading within bounds"); }

Handle written_access() { return access_by<Written>("writing"); }

std::shared_ptr<WrittenFile> written_file(hid_t file) {
    void* found = nullptr;
    check(H5Fget_vfd_handle(file, H5P_DEFAULT, &found), "file driver");
    return *static_cast<std::shared_ptr<WrittenFile>*>(found);
}

}  // namespace shaker::h5
