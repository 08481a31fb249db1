#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <mutex>

#include "drivers/errors.hpp"
#include "drivers/recorded/h5/file_driver.hpp"
#include "drivers/recorded/h5/file_lock.hpp"
#include "drivers/recorded/h5/h5.hpp"
#include "drivers/recorded/h5/written_file.hpp"

namespace shaker::h5 {

void refuse(const std::string& path, const std::string& why) {
    throw InputError{"recording: \"" + path + "\" " + why};
}

Handle readable(hid_t id, const std::string& path) {
    if (id < 0) refuse(path, "cannot be read: " + own_words());
    return {id, path};
}

void readable(herr_t status, const std::string& path) {
    if (status < 0) refuse(path, "cannot be read: " + own_words());
}

std::string why_not(hid_t parent, const std::string& path) {
    std::string words = own_words();
    for (std::size_t end = path.find('/', 1);; end = path.find('/', end + 1)) {
        H5L_info_t link{};
        if (H5Lget_info(parent, path.substr(0, end).c_str(), &link, H5P_DEFAULT) < 0) return words;
        if (link.type >= H5L_TYPE_UD_MIN) return "it is a link to another file; other files are not opened";
        if (end == std::string::npos) return words;
    }
}

namespace {

/// Refuses a group whose links are not all readable. HDF5 1.10 lists a small group by a table, and if that
/// fails it frees entries that it never set; searching for a missing name reads them all first.
void expect_links(hid_t group, const std::string& path) {
    const htri_t found = H5Lexists(group, "\x01", H5P_DEFAULT);
    readable(found, path);
    if (found > 0) refuse(path, "has an invalid name");
}

/// Prevents a file from loading plug-ins or opening other files. Several threads may open their first file.
void stay_in_the_file() {
    static std::mutex one_at_a_time;
    const std::scoped_lock lock{one_at_a_time};
    check(H5PLset_loading_state(0), "refusing plug-ins");
    if (H5Lis_registered(H5L_TYPE_EXTERNAL) > 0)
        check(H5Lunregister(H5L_TYPE_EXTERNAL), "refusing links to other files");
}

/// True if the file is marked as open for writing, or its writer died: a byte of the superblock of version 3.
bool has_a_writer(const std::filesystem::path& file) {
    std::array<char, 12> begin{};
    std::ifstream{file, std::ios::binary}.read(begin.data(), begin.size());
    return begin[8] == 3 && begin[11] != 0;
}

}  // namespace

Handle open_file(const std::filesystem::path& file, Access access) {
    be_quiet();
    stay_in_the_file();
    if (std::filesystem::is_directory(file))
        throw InputError{file.string() + ": is a folder; expected a recording (FILE.nxs)"};
    if (!std::filesystem::is_regular_file(file)) throw InputError{file.string() + ": no such file"};
    if (H5Fis_hdf5(file.c_str()) <= 0) throw InputError{file.string() + ": not an HDF5 file"};
    const bool growing = access == Access::growing;
    const Handle way = growing ? Handle{H5Pcreate(H5P_FILE_ACCESS), file.string()} : bounded_access();
    // A file that is being written may be read half-written: repeated, but not endlessly.
    constexpr unsigned attempts = 20;
    if (growing) check(H5Pset_metadata_read_attempts(way.get(), attempts), file.string());
    const unsigned how = growing ? H5F_ACC_RDONLY | H5F_ACC_SWMR_READ : H5F_ACC_RDONLY;
    const hid_t id = H5Fopen(file.c_str(), how, way.get());
    if (id >= 0) return {id, file.string()};
    const std::string why = own_words();
    if (const auto writer = locked_by(file); !growing && writer)
        throw InputError{fmt::format("{}: is being recorded by process {}; wait until it is complete",
                                     file.string(), *writer)};
    if (!growing && has_a_writer(file))
        throw InputError{fmt::format(
            "{0}: its writer ended without closing it; \"shakerd recover {0}\" completes it", file.string())};
    throw InputError{file.string() + ": cannot be opened: " + why};
}

Handle open_to_mend(const std::filesystem::path& file) {
    be_quiet();
    stay_in_the_file();
    const Handle access = written_access();
    const hbool_t clear = 1;  // the mark of a writer that never closed the file; h5clear removes it too
    check(H5Pset(access.get(), "clear_status_flags", &clear), file.string());
    check(H5Pset_libver_bounds(access.get(), H5F_LIBVER_LATEST, H5F_LIBVER_LATEST), file.string());
    const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDWR, access.get());
    if (id < 0) throw InputError{file.string() + ": cannot be opened: " + own_words()};
    Handle opened{id, file.string()};
    // A writer that dies during a flush leaves objects beyond the recorded end of the file.
    check(H5Fincrement_filesize(id, 0), file.string());
    return opened;
}

Handle open_group(hid_t parent, const std::string& path) {
    be_quiet();
    const hid_t id = H5Gopen2(parent, path.c_str(), H5P_DEFAULT);
    if (id < 0) refuse(path, "cannot be read: " + why_not(parent, path));
    return {id, path};
}

bool exists(hid_t parent, const std::string& path) {
    be_quiet();
    for (std::size_t end = path.find('/', 1);; end = path.find('/', end + 1)) {
        if (H5Lexists(parent, path.substr(0, end).c_str(), H5P_DEFAULT) <= 0) return false;
        if (end == std::string::npos) return true;
    }
}

std::vector<std::string> names_in(hid_t parent, const std::string& path) {
    std::vector<std::string> names;
    if (!exists(parent, path)) return names;
    const Handle group = open_group(parent, path);
    expect_links(group.get(), path);
    // In the order of the file: for sorting, HDF5 1.10 uses a table for large groups too.
    readable(H5Literate(
                 group.get(), H5_INDEX_NAME, H5_ITER_NATIVE, nullptr,
                 [](hid_t, const char* name, const H5L_info_t*, void* out) -> herr_t {
                     static_cast<std::vector<std::string>*>(out)->emplace_back(name);
                     return 0;
                 },
                 &names),
             path);
    std::ranges::sort(names);
    return names;
}

}  // namespace shaker::h5
