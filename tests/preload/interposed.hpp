#pragma once
// For preloaded libraries between a program and the C library: functions of the C library itself, and
// selection of files.
#include <dlfcn.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

namespace shaker::interposed {

/// The C library's function of this name.
template <class Function>
Function* real(const char* name) noexcept {
    return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

/// Folder of the selected files, including subfolders; empty: no files.
inline const std::string& folder() {
    static const std::string path = [] {
        const char* name = std::getenv("SHAKER_DISK_FOLDER");
        return std::string{name == nullptr ? "" : name};
    }();
    return path;
}

inline bool is_meant(std::string_view path) {
    return !folder().empty() && path.starts_with(folder()) &&
           (path.size() == folder().size() || path[folder().size()] == '/');
}

/// The name of an open selected file; empty for other files.
inline std::string meant(int descriptor) {
    if (folder().empty()) return {};
    const int before = errno;
    std::array<char, 4096> path{};
    const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
    const ssize_t n = ::readlink(link.c_str(), path.data(), path.size());
    errno = before;
    const std::string_view name{path.data(), n > 0 ? static_cast<std::size_t>(n) : 0};
    return is_meant(name) ? std::string{name} : std::string{};
}

/// The absolute path for a path given by the program.
inline std::string absolute(const char* path) {
    if (path[0] == '/') return path;
    std::array<char, 4096> here{};
    const int before = errno;
    std::string base = ::getcwd(here.data(), here.size()) == nullptr ? "" : here.data();
    errno = before;
    while (std::string_view{path}.starts_with("./")) path += 2;
    return std::string_view{path} == "." ? base : base + "/" + path;
}

}  // namespace shaker::interposed
