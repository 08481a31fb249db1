#include "drivers/recorded/h5/h5.hpp"

#include <algorithm>

#include "drivers/errors.hpp"
#include "drivers/recorded/h5/written_file.hpp"

namespace shaker::h5 {

namespace {

constexpr hsize_t page = 4096;  // bytes, page of disks and of the kernel

Handle plist(hid_t kind) { return {H5Pcreate(kind), "property list"}; }

// Stores any number of links and attributes of a group in its header: one block with one checksum.
void keep_together(hid_t create) {
    constexpr unsigned most = 4096;
    check(H5Pset_link_phase_change(create, most, most), "group");
    check(H5Pset_attr_phase_change(create, most, most), "group");
}

// Each column keeps the chunk in memory that is being filled. By default it would keep its last megabyte. Set
// for the file, because the start of the writer for many readers opens the columns again.
void keep_one_chunk(hid_t access, const std::string& name) {
    constexpr int unused = 0;
    constexpr std::size_t slots = 1, most_bytes = 1U << 20U;
    constexpr double drop_full_chunks = 1;
    check(H5Pset_cache(access, unused, slots, most_bytes, drop_full_chunks), name);
}

// Concatenated texts, each padded to the length of the longest.
std::pair<std::size_t, std::string> as_block(const std::vector<std::string>& texts) {
    std::size_t longest = 1;
    for (const std::string& t : texts) longest = std::max(longest, t.size());
    std::string block;
    for (std::string t : texts) {
        t.resize(longest, '\0');
        block += t;
    }
    return {longest, block};
}

// HDF5 adds time, descriptor and buffer to the system's error text.
std::string shortened(const std::string& words) {
    const std::string quote = "error message = '";
    const std::size_t call = words.find(": time = "), at = words.find(quote);
    if (call == std::string::npos || at == std::string::npos) return words;
    const std::size_t from = at + quote.size();
    return words.substr(0, call) + ": " + words.substr(from, words.find('\'', from) - from);
}

}  // namespace

std::string own_words() {
    std::string words;
    H5Ewalk2(
        H5E_DEFAULT, H5E_WALK_UPWARD,
        [](unsigned, const H5E_error2_t* e, void* out) -> herr_t {
            auto& text = *static_cast<std::string*>(out);
            if (text.empty() && e->desc != nullptr) text = e->desc;
            return 0;
        },
        &words);
    return words.empty() ? "unknown HDF5 error" : shortened(words);
}

// HDF5 prints its error stack by default; here its text is thrown instead. At the end of the program it would
// access its files again, and crashes if one could not be written.
void be_quiet() {
    static const herr_t at_end = H5dont_atexit();
    static_cast<void>(at_end);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

Handle::Handle(hid_t id, const std::string& what) : id_{id} {
    if (id < 0) throw DeviceError{what + ": " + own_words()};
}

Handle& Handle::operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
}

Handle::~Handle() {
    if (id_ >= 0) H5Idec_ref(id_);
}

void check(herr_t status, const std::string& what) {
    if (status < 0) throw DeviceError{what + ": " + own_words()};
}

Handle text_type(std::size_t bytes) {
    Handle type{H5Tcopy(H5T_C_S1), "string type"};
    check(H5Tset_size(type.get(), std::max<std::size_t>(1, bytes)), "string size");
    check(H5Tset_cset(type.get(), H5T_CSET_UTF8), "string character set");
    return type;
}

template <>
hid_t type_of<double>() noexcept {
    return H5T_NATIVE_DOUBLE;
}
template <>
hid_t type_of<std::int64_t>() noexcept {
    return H5T_NATIVE_INT64;
}
template <>
hid_t type_of<std::uint64_t>() noexcept {
    return H5T_NATIVE_UINT64;
}
template <>
hid_t type_of<std::int32_t>() noexcept {
    return H5T_NATIVE_INT32;
}
template <>
hid_t type_of<std::uint8_t>() noexcept {
    return H5T_NATIVE_UINT8;
}
template <>
hid_t type_of<std::uint16_t>() noexcept {
    return H5T_NATIVE_UINT16;
}

Handle create_file(const std::filesystem::path& file) {
    be_quiet();
    const Handle access = written_access();
    check(H5Pset_libver_bounds(access.get(), H5F_LIBVER_LATEST, H5F_LIBVER_LATEST), file.string());
    check(H5Pset_alignment(access.get(), 1, page), file.string());
    keep_one_chunk(access.get(), file.string());
    const Handle create = plist(H5P_FILE_CREATE);
    check(H5Pset_obj_track_times(create.get(), false), file.string());  // equal content gives equal bytes
    keep_together(create.get());
    return {H5Fcreate(file.c_str(), H5F_ACC_TRUNC, create.get(), access.get()), file.string()};
}

void let_others_read(hid_t file, const std::string& name) {
    check(H5Fstart_swmr_write(file), name);
    written_file(file)->require_whole(name);
}

void flush(hid_t file, const std::string& name) {
    check(H5Fflush(file, H5F_SCOPE_GLOBAL), name);
    written_file(file)->require_whole(name);
}

void sync(hid_t file, const std::string& name) {
    const auto written = written_file(file);
    written->sync();
    written->require_whole(name);
}

void close_file(Handle file, const std::string& name) {
    flush(file.get(), name);
    const ssize_t open = H5Fget_obj_count(file.get(), H5F_OBJ_ALL);
    if (open != 1) throw DeviceError{name + ": " + std::to_string(open - 1) + " objects are still open"};
    const auto written = written_file(file.get());
    check(H5Fclose(file.release()), name);
    written->sync();
    written->require_whole(name);
}

Handle make_group(hid_t parent, const std::string& path, const std::string& nx_class) {
    // Groups on the way are created one by one: HDF5 itself would store the time of day in them.
    for (std::size_t end = path.find('/'); end != std::string::npos; end = path.find('/', end + 1))
        if (!exists(parent, path.substr(0, end))) make_group(parent, path.substr(0, end), "NXcollection");
    const Handle create = plist(H5P_GROUP_CREATE);
    check(H5Pset_obj_track_times(create.get(), false), path);
    keep_together(create.get());
    Handle group{H5Gcreate2(parent, path.c_str(), H5P_DEFAULT, create.get(), H5P_DEFAULT), path};
    if (!nx_class.empty()) set_attribute(group.get(), "NX_class", nx_class);
    return group;
}

void set_attribute(hid_t object, const std::string& name, const std::string& text) {
    const Handle type = text_type(text.size());
    const Handle space{H5Screate(H5S_SCALAR), name};
    const Handle a{H5Acreate2(object, name.c_str(), type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT), name};
    const std::string padded = text.empty() ? std::string(1, '\0') : text;
    check(H5Awrite(a.get(), type.get(), padded.data()), name);
}

void set_attribute(hid_t object, const std::string& name, const std::vector<std::string>& texts) {
    const auto [longest, block] = as_block(texts);
    const Handle type = text_type(longest);
    const hsize_t count = texts.size();
    const Handle space{H5Screate_simple(1, &count, nullptr), name};
    const Handle a{H5Acreate2(object, name.c_str(), type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT), name};
    check(H5Awrite(a.get(), type.get(), block.data()), name);
}

void set_attribute(hid_t object, const std::string& name, double value) {
    const Handle space{H5Screate(H5S_SCALAR), name};
    const Handle a{H5Acreate2(object, name.c_str(), H5T_IEEE_F64LE, space.get(), H5P_DEFAULT, H5P_DEFAULT),
                   name};
    check(H5Awrite(a.get(), H5T_NATIVE_DOUBLE, &value), name);
}

void set_attribute(hid_t object, const std::string& name, std::int64_t value) {
    const Handle space{H5Screate(H5S_SCALAR), name};
    const Handle a{H5Acreate2(object, name.c_str(), H5T_STD_I64LE, space.get(), H5P_DEFAULT, H5P_DEFAULT),
                   name};
    check(H5Awrite(a.get(), H5T_NATIVE_INT64, &value), name);
}

template <Element T>
void write(hid_t parent, const std::string& name, std::span<const T> values, std::vector<hsize_t> shape,
           const std::string& units) {
    const Handle create = plist(H5P_DATASET_CREATE);
    check(H5Pset_obj_track_times(create.get(), false), name);
    const Handle space{shape.empty()
                           ? H5Screate(H5S_SCALAR)
                           : H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr),
                       name};
    const Handle set{
        H5Dcreate2(parent, name.c_str(), type_of<T>(), space.get(), H5P_DEFAULT, create.get(), H5P_DEFAULT),
        name};
    if (!values.empty())
        check(H5Dwrite(set.get(), type_of<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), name);
    set_attribute(set.get(), "units", units.empty() ? "1" : units);
}

Handle make_value(hid_t parent, const std::string& name, hid_t type) {
    const Handle create = plist(H5P_DATASET_CREATE);
    check(H5Pset_obj_track_times(create.get(), false), name);
    check(H5Pset_alloc_time(create.get(), H5D_ALLOC_TIME_EARLY), name);
    const Handle space{H5Screate(H5S_SCALAR), name};
    return {H5Dcreate2(parent, name.c_str(), type, space.get(), H5P_DEFAULT, create.get(), H5P_DEFAULT),
            name};
}

void write_text(hid_t parent, const std::string& name, const std::string& text) {
    const Handle create = plist(H5P_DATASET_CREATE);
    check(H5Pset_obj_track_times(create.get(), false), name);
    const Handle type = text_type(text.size());
    const Handle space{H5Screate(H5S_SCALAR), name};
    const Handle set{
        H5Dcreate2(parent, name.c_str(), type.get(), space.get(), H5P_DEFAULT, create.get(), H5P_DEFAULT),
        name};
    const std::string padded = text.empty() ? std::string(1, '\0') : text;
    check(H5Dwrite(set.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, padded.data()), name);
}

void write_texts(hid_t parent, const std::string& name, const std::vector<std::string>& texts) {
    const Handle create = plist(H5P_DATASET_CREATE);
    check(H5Pset_obj_track_times(create.get(), false), name);
    const auto [longest, block] = as_block(texts);
    const Handle type = text_type(longest);
    const hsize_t count = texts.size();
    const Handle space{H5Screate_simple(1, &count, nullptr), name};
    const Handle set{
        H5Dcreate2(parent, name.c_str(), type.get(), space.get(), H5P_DEFAULT, create.get(), H5P_DEFAULT),
        name};
    if (!texts.empty())
        check(H5Dwrite(set.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, block.data()), name);
}

template void write(hid_t, const std::string&, std::span<const double>, std::vector<hsize_t>,
                    const std::string&);
template void write(hid_t, const std::string&, std::span<const std::int64_t>, std::vector<hsize_t>,
                    const std::string&);
template void write(hid_t, const std::string&, std::span<const std::uint64_t>, std::vector<hsize_t>,
                    const std::string&);

}  // namespace shaker::h5
