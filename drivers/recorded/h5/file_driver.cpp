#include "drivers/recorded/h5/file_driver.hpp"

#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#include <tuple>

namespace shaker::h5 {

static_assert(H5_VERS_MAJOR == 1 && H5_VERS_MINOR == 10, "later versions describe a driver differently");

namespace {

struct stat status_of(int descriptor) {
    struct stat status {};
    ::fstat(descriptor, &status);
    return status;
}

}  // namespace

void add_error(const std::string& what, hid_t why) {
    H5Epush2(H5E_DEFAULT, __FILE__, __func__, __LINE__, H5E_ERR_CLS, H5E_IO, why, "%s", what.c_str());
}

std::string text_of(int error) { return std::generic_category().message(error); }

int compare(int descriptor, int other) {
    const struct stat x = status_of(descriptor), y = status_of(other);
    const auto left = std::tie(x.st_dev, x.st_ino), right = std::tie(y.st_dev, y.st_ino);
    return left < right ? -1 : static_cast<int>(right < left);
}

haddr_t length_of(int descriptor) { return static_cast<haddr_t>(status_of(descriptor).st_size); }

herr_t lock_by_hdf5(int descriptor, int operation) {
    if (::flock(descriptor, operation) == 0 || errno == ENOSYS) return 0;
    add_error(text_of(errno), H5E_CANTOPENFILE);
    return -1;
}

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

H5FD_class_t empty_driver(const char* name) {
    H5FD_class_t driver{};
    driver.name = name;
    driver.maxaddr = static_cast<haddr_t>(INT64_MAX);
    driver.fc_degree = H5F_CLOSE_WEAK;
    const H5FD_mem_t kinds[H5FD_MEM_NTYPES] = H5FD_FLMAP_DICHOTOMY;
    std::memcpy(driver.fl_map, kinds, sizeof kinds);
    return driver;
}

}  // namespace shaker::h5
