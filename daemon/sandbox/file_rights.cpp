#include "daemon/sandbox/file_rights.hpp"

#include <fcntl.h>
#include <linux/landlock.h>
#include <spdlog/fmt/fmt.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>

#include "drivers/descriptor.hpp"

namespace shaker::sandbox {

namespace {

// Rights that came after the headers of Debian 12; the version of the interface that knows them.
constexpr std::uint64_t fs_refer = 1U << 13U;      // 2
constexpr std::uint64_t fs_truncate = 1U << 14U;   // 3
constexpr std::uint64_t net_bind_connect = 3;      // 4
constexpr std::uint64_t fs_ioctl_dev = 1U << 15U;  // 5
constexpr std::uint64_t scope_all = 3;             // 6: abstract sockets and signals

constexpr std::uint64_t read_file = LANDLOCK_ACCESS_FS_READ_FILE;
constexpr std::uint64_t read_folder = read_file | LANDLOCK_ACCESS_FS_READ_DIR;
constexpr std::uint64_t run_file = read_file | LANDLOCK_ACCESS_FS_EXECUTE;
constexpr std::uint64_t write_file = read_file | LANDLOCK_ACCESS_FS_WRITE_FILE | fs_truncate;
constexpr std::uint64_t write_folder = read_folder | write_file | LANDLOCK_ACCESS_FS_MAKE_REG |
                                       LANDLOCK_ACCESS_FS_MAKE_DIR | LANDLOCK_ACCESS_FS_REMOVE_FILE |
                                       LANDLOCK_ACCESS_FS_REMOVE_DIR;

// Files of the system that libraries open while a file is read (threads of OpenCV, local time), and the
// process's own state.
constexpr std::array system_files{"/usr/lib",
                                  "/usr/local/lib",
                                  "/lib",
                                  "/lib64",
                                  "/etc/ld.so.cache",
                                  "/etc/localtime",
                                  "/usr/share/zoneinfo",
                                  "/sys/devices/system/cpu",
                                  "/proc/self"};

// The kernel's landlock_ruleset_attr of version 6. Older kernels take its beginning.
struct Handled {
    std::uint64_t files, net, scope;
};

// Zero, or errno. Files that cannot be opened are passed over: the child cannot open them either. So are
// links to what may be written: others could change them meanwhile.
int allow(int rules, const std::filesystem::path& path, std::uint64_t for_file, std::uint64_t for_folder,
          std::uint64_t known) {
    const bool writes = (for_file & LANDLOCK_ACCESS_FS_WRITE_FILE) != 0;
    const Descriptor there{::open(path.c_str(), O_PATH | O_CLOEXEC | (writes ? O_NOFOLLOW : 0))};
    struct stat status {};
    if (there < 0 || ::fstat(there, &status) < 0 || S_ISLNK(status.st_mode)) return 0;
    landlock_path_beneath_attr rule{};
    rule.allowed_access = (S_ISDIR(status.st_mode) ? for_folder : for_file) & known;
    if (rule.allowed_access == 0) return 0;
    rule.parent_fd = there;
    if (::syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &rule, 0) == 0) return 0;
    return errno == EBADFD ? 0 : errno;  // a pipe or a socket, which has no place among the files
}

std::string refused(const char* what, int error) { return fmt::format("{}: {}", what, std::strerror(error)); }

}  // namespace

std::string restrict_files(const FileRights& allowed) {
    const long version = ::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
    if (version < 1) return refused("Landlock", errno);
    Handled handled{.files = fs_refer - 1, .net = 0, .scope = 0};  // all of version 1
    if (version >= 2) handled.files |= fs_refer;
    if (version >= 3) handled.files |= fs_truncate;
    if (version >= 4) handled.net = net_bind_connect;
    if (version >= 5) handled.files |= fs_ioctl_dev;
    if (version >= 6) handled.scope = scope_all;
    const std::size_t size = version < 4   ? sizeof handled.files
                             : version < 6 ? 2 * sizeof handled.net
                                           : sizeof handled;
    const Descriptor rules{static_cast<int>(::syscall(SYS_landlock_create_ruleset, &handled, size, 0))};
    if (rules < 0) return refused("Landlock", errno);
    int error = 0;
    const auto add = [&](const std::filesystem::path& path, std::uint64_t for_file,
                         std::uint64_t for_folder) {
        if (error == 0) error = allow(rules, path, for_file, for_folder, handled.files);
    };
    for (const char* path : system_files) add(path, read_file, read_folder);
    for (const auto& path : allowed.lists) add(path, 0, LANDLOCK_ACCESS_FS_READ_DIR);
    for (const auto& path : allowed.reads) add(path, read_file, read_folder);
    for (const auto& path : allowed.runs) add(path, run_file, read_folder | run_file);
    for (const auto& path : allowed.writes) add(path, write_file, write_folder);
    if (error == 0 && ::syscall(SYS_landlock_restrict_self, int{rules}, 0) < 0) error = errno;
    return error == 0 ? "" : refused("Landlock", error);
}

}  // namespace shaker::sandbox
