#include <algorithm>
#include <array>
#include <fstream>
#include <limits>
#include <optional>

#include "drivers/errors.hpp"
#include "drivers/replay/h5.hpp"
#include "drivers/replay/h5_bounded.hpp"

namespace shaker::h5 {

namespace {

constexpr std::size_t text_limit = 16U << 20U;

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
    throw InputError{"recording: \"" + path + "\" " + why};
}

/// A handle that is only read through; what cannot be had is the file's fault.
Handle readable(hid_t id, const std::string& path) {
    if (id < 0) refuse(path, "cannot be read: " + own_words());
    return {id, path};
}

void readable(herr_t status, const std::string& path) {
    if (status < 0) refuse(path, "cannot be read: " + own_words());
}

hsize_t file_size(hid_t object, const std::string& path) {
    const Handle file = readable(H5Iget_file_id(object), path);
    hsize_t size = 0;
    readable(H5Fget_filesize(file.get(), &size), path);
    return size;
}

/// a b, or nothing beyond `most`.
std::optional<hsize_t> product(hsize_t a, hsize_t b, hsize_t most) {
    if (b != 0 && a > most / b) return std::nullopt;
    return a * b;
}

/// Why HDF5 did not open what `path` names.
std::string why_not(hid_t parent, const std::string& path) {
    std::string words = own_words();
    for (std::size_t end = path.find('/', 1);; end = path.find('/', end + 1)) {
        H5L_info_t link{};
        if (H5Lget_info(parent, path.substr(0, end).c_str(), &link, H5P_DEFAULT) < 0) return words;
        if (link.type >= H5L_TYPE_UD_MIN) return "it is a link to another file, and no other file is opened";
        if (end == std::string::npos) return words;
    }
}

struct Opened {
    Handle set, type;
    std::vector<hsize_t> shape;
};

std::vector<hsize_t> extents(hid_t space, const std::string& path) {
    const int rank = H5Sget_simple_extent_ndims(space);
    if (rank < 0 || H5Sget_simple_extent_type(space) == H5S_NULL) refuse(path, "has no shape");
    std::vector<hsize_t> shape(static_cast<std::size_t>(rank));
    readable(H5Sget_simple_extent_dims(space, shape.data(), nullptr), path);
    return shape;
}

Opened opened(hid_t parent, const std::string& path) {
    be_quiet();
    const hid_t id = H5Dopen2(parent, path.c_str(), H5P_DEFAULT);
    if (id < 0) throw InputError{"recording has no data set \"" + path + "\": " + why_not(parent, path)};
    Handle set{id, path};
    Handle type = readable(H5Dget_type(set.get()), path);
    const Handle space = readable(H5Dget_space(set.get()), path);
    return {std::move(set), std::move(type), extents(space.get(), path)};
}

/// Bytes of a shape, refused when they are more than `most`.
hsize_t bytes_of(const std::vector<hsize_t>& shape, hsize_t element, hsize_t most, const std::string& path) {
    std::optional<hsize_t> bytes = element;
    for (const hsize_t n : shape) bytes = bytes ? product(*bytes, n, most) : bytes;
    if (!bytes) refuse(path, "claims to be larger than the file");
    return *bytes;
}

/// Refuses chunks in rows `first` to `last` (not included) that are not as long in the file as their shape
/// says: HDF5 1.10 takes memory for the one and copies by the other. Only the old index keeps their length;
/// in those of later formats the library would look for each chunk through all of the index, however long
/// that claims to be.
void expect_chunks(const Opened& data, const std::vector<hsize_t>& chunk, hsize_t bytes, hsize_t first,
                   hsize_t last, const std::string& path) {
    H5D_chunk_index_t index{};
    readable(H5Dget_chunk_index_type(data.set.get(), &index), path);
    if (index != H5D_CHUNK_IDX_BTREE) return;
    std::vector<hsize_t> at(chunk.size(), 0);
    at[0] = first - first % chunk[0];
    while (at[0] < last) {
        unsigned filters = 0;
        haddr_t address = 0;
        hsize_t stored = 0;
        readable(H5Dget_chunk_info_by_coord(data.set.get(), at.data(), &filters, &address, &stored), path);
        if (address != HADDR_UNDEF && stored != bytes)
            refuse(path, "has a chunk of another size than it claims");
        std::size_t axis = at.size() - 1;
        while ((at[axis] += chunk[axis]) >= data.shape[axis] && axis > 0) at[axis--] = 0;
    }
}

/// Elements of a data set, of which rows `first` to `last` (not included, or the end) are safe to read after
/// this.
std::size_t counted(const Opened& data, const std::string& path, hsize_t first = 0,
                    hsize_t last = std::numeric_limits<hsize_t>::max()) {
    const Handle create = readable(H5Dget_create_plist(data.set.get()), path);
    const H5D_layout_t layout = H5Pget_layout(create.get());
    if (layout == H5D_VIRTUAL || H5Pget_external_count(create.get()) != 0)
        refuse(path, "is kept in other files");
    if (H5Pget_nfilters(create.get()) != 0)
        refuse(path, "is compressed, which recordings of shakerd are not");
    if (std::ranges::find(data.shape, hsize_t{0}) != data.shape.end()) return 0;
    const hsize_t element = H5Tget_size(data.type.get());
    const hsize_t most = file_size(data.set.get(), path);
    const hsize_t bytes = bytes_of(data.shape, element, most, path);
    if (layout == H5D_CHUNKED) {
        std::vector<hsize_t> chunk(data.shape.size());
        const int rank = H5Pget_chunk(create.get(), static_cast<int>(chunk.size()), chunk.data());
        if (chunk.empty() || rank != static_cast<int>(chunk.size()) ||
            std::ranges::find(chunk, hsize_t{0}) != chunk.end())
            refuse(path, "has chunks of another rank");
        expect_chunks(data, chunk, bytes_of(chunk, element, most, path), first, std::min(last, data.shape[0]),
                      path);
    }
    return static_cast<std::size_t>(bytes / element);
}

/// Same kind, size and layout of bits, in either order of bytes.
bool same_type(hid_t type, hid_t native) {
    const Handle copy{H5Tcopy(native), "number type"};
    if (H5Tget_class(type) != H5Tget_class(native) || H5Tget_size(type) != H5Tget_size(native)) return false;
    const H5T_order_t order = H5Tget_order(type);
    if (order != H5T_ORDER_LE && order != H5T_ORDER_BE) return H5Tequal(type, native) > 0;
    check(H5Tset_order(copy.get(), order), "number type");
    return H5Tequal(type, copy.get()) > 0;
}

template <Element T>
void expect_type(const Opened& data, const std::string& path) {
    if (!same_type(data.type.get(), type_of<T>())) refuse(path, "is not of the expected number type");
}

void expect_text(hid_t type, const std::string& what) {
    if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) != 0 || H5Tget_size(type) > text_limit)
        refuse(what, "is not a fixed-length text");
}

struct Attribute {
    Handle id, type;
    std::string what;
};

/// An attribute with one value.
Attribute attribute_at(hid_t parent, const std::string& path, const std::string& name) {
    be_quiet();
    const std::string what = path + "@" + name;
    const hid_t id = H5Aopen_by_name(parent, path.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
    if (id < 0) throw InputError{"recording has no attribute \"" + what + "\": " + why_not(parent, path)};
    Handle attribute{id, what};
    const Handle space = readable(H5Aget_space(id), what);
    if (H5Sget_simple_extent_npoints(space.get()) != 1) refuse(what, "is not one value");
    Handle type = readable(H5Aget_type(id), what);
    return {std::move(attribute), std::move(type), what};
}

std::string trimmed(std::string text) {
    text.resize(std::min(text.size(), text.find('\0')));
    return text;
}

/// Refuses a group of which not every link can be read. HDF5 1.10 lists a small group by a table, and where
/// it cannot fill that it frees entries that it never set; to look for a name that is not there reads them
/// all.
void expect_links(hid_t group, const std::string& path) {
    const htri_t found = H5Lexists(group, "\x01", H5P_DEFAULT);
    readable(found, path);
    if (found > 0) refuse(path, "has a name that none has");
}

/// A file names no code to load and no other file to open, whoever made it.
void stay_in_the_file() {
    check(H5PLset_loading_state(0), "refusing plug-ins");
    if (H5Lis_registered(H5L_TYPE_EXTERNAL) > 0)
        check(H5Lunregister(H5L_TYPE_EXTERNAL), "refusing links to other files");
}

/// The file says that somebody has it open for writing, or died before closing it: a byte of the superblock
/// of version 3.
bool has_a_writer(const std::filesystem::path& file) {
    std::array<char, 12> begin{};
    std::ifstream{file, std::ios::binary}.read(begin.data(), begin.size());
    return begin[8] == 3 && begin[11] != 0;
}

}  // namespace

Handle open_file(const std::filesystem::path& file, Access access) {
    be_quiet();
    stay_in_the_file();
    if (!std::filesystem::is_regular_file(file)) throw InputError{file.string() + ": no such file"};
    if (H5Fis_hdf5(file.c_str()) <= 0) throw InputError{file.string() + ": not an HDF5 file"};
    const bool growing = access == Access::growing;
    const Handle way = growing ? Handle{H5Pcreate(H5P_FILE_ACCESS), file.string()} : bounded_access();
    // What is being written may be read half: once more then, but not for ever.
    constexpr unsigned attempts = 20;
    if (growing) check(H5Pset_metadata_read_attempts(way.get(), attempts), file.string());
    const unsigned how = growing ? H5F_ACC_RDONLY | H5F_ACC_SWMR_READ : H5F_ACC_RDONLY;
    const hid_t id = H5Fopen(file.c_str(), how, way.get());
    if (id >= 0) return {id, file.string()};
    const std::string why = own_words();
    if (!growing && has_a_writer(file))
        throw InputError{file.string() +
                         ": is still being written, or was never finished: then \"shakerd recover " +
                         file.string() + "\" finishes it"};
    throw InputError{file.string() + ": cannot be opened: " + why};
}

Handle open_to_mend(const std::filesystem::path& file) {
    be_quiet();
    stay_in_the_file();
    const Handle access{H5Pcreate(H5P_FILE_ACCESS), file.string()};
    const hbool_t clear = 1;  // the mark of a writer that never closed it; what h5clear does too
    check(H5Pset(access.get(), "clear_status_flags", &clear), file.string());
    check(H5Pset_libver_bounds(access.get(), H5F_LIBVER_LATEST, H5F_LIBVER_LATEST), file.string());
    const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDWR, access.get());
    if (id < 0) throw InputError{file.string() + ": cannot be opened: " + own_words()};
    Handle opened{id, file.string()};
    // A writer that dies within a flush has objects behind the end that the file tells of.
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
    // In the order of the file: to sort them HDF5 1.10 makes a table of large groups too.
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

Description description_of(hid_t parent, const std::string& path) {
    Opened data = opened(parent, path);
    counted(data, path, 0, 0);  // the rows are looked at when they are read
    return {std::move(data.shape), H5Tget_size(data.type.get())};
}

template <Element T>
std::vector<T> read(hid_t parent, const std::string& path, std::size_t limit) {
    const Opened data = opened(parent, path);
    expect_type<T>(data, path);
    const std::size_t count = counted(data, path);
    if (count > limit)
        refuse(path,
               "has " + std::to_string(count) + " elements, at most " + std::to_string(limit) + " are read");
    std::vector<T> values(count);
    if (!values.empty())
        readable(H5Dread(data.set.get(), type_of<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), path);
    return values;
}

std::string read_text(hid_t parent, const std::string& path) {
    const Opened data = opened(parent, path);
    expect_text(data.type.get(), path);
    if (counted(data, path) != 1) refuse(path, "is not one text");
    std::string text(H5Tget_size(data.type.get()), '\0');
    readable(H5Dread(data.set.get(), data.type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()), path);
    return trimmed(std::move(text));
}

Bytes read_bytes(hid_t parent, const std::string& path) {
    const Opened data = opened(parent, path);
    const H5T_class_t kind = H5Tget_class(data.type.get());
    if (kind == H5T_STRING)
        expect_text(data.type.get(), path);
    else if (kind != H5T_INTEGER && kind != H5T_FLOAT)
        refuse(path, "is neither numbers nor text");
    Bytes bytes;
    bytes.row = H5Tget_size(data.type.get());
    bytes.values.resize(counted(data, path) * bytes.row);
    for (std::size_t axis = 1; axis < data.shape.size(); ++axis) bytes.row *= data.shape[axis];
    if (!bytes.values.empty())
        readable(H5Dread(data.set.get(), data.type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.values.data()),
                 path);
    return bytes;
}

std::vector<std::string> read_texts(hid_t parent, const std::string& path) {
    const Opened data = opened(parent, path);
    expect_text(data.type.get(), path);
    const std::size_t count = counted(data, path), length = H5Tget_size(data.type.get());
    std::string block(count * length, '\0');
    if (count > 0)
        readable(H5Dread(data.set.get(), data.type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, block.data()), path);
    std::vector<std::string> texts;
    for (std::size_t i = 0; i < count; ++i) texts.push_back(trimmed(block.substr(i * length, length)));
    return texts;
}

bool has_attribute(hid_t parent, const std::string& path, const std::string& name) {
    be_quiet();
    return exists(parent, path) && H5Aexists_by_name(parent, path.c_str(), name.c_str(), H5P_DEFAULT) > 0;
}

std::string read_attribute_text(hid_t parent, const std::string& path, const std::string& name) {
    const Attribute a = attribute_at(parent, path, name);
    expect_text(a.type.get(), a.what);
    std::string text(H5Tget_size(a.type.get()), '\0');
    readable(H5Aread(a.id.get(), a.type.get(), text.data()), a.what);
    return trimmed(std::move(text));
}

double read_attribute(hid_t parent, const std::string& path, const std::string& name) {
    const Attribute a = attribute_at(parent, path, name);
    if (!same_type(a.type.get(), type_of<double>()) && !same_type(a.type.get(), type_of<std::int64_t>()))
        refuse(a.what, "is not a number of 64 bits");
    double value = 0;
    readable(H5Aread(a.id.get(), type_of<double>(), &value), a.what);
    return value;
}

template <Element T>
void read_row(hid_t parent, const std::string& path, hsize_t index, std::span<T> row) {
    const Opened data = opened(parent, path);
    expect_type<T>(data, path);
    const std::size_t count = counted(data, path, index, index + 1);
    if (data.shape.empty() || index >= data.shape[0] || count / data.shape[0] != row.size())
        refuse(path, "has no row " + std::to_string(index) + " of the expected size");
    std::vector<hsize_t> start(data.shape.size(), 0);
    start[0] = index;
    std::vector<hsize_t> extent = data.shape;
    extent[0] = 1;
    const hsize_t size = row.size();
    const Handle space = readable(H5Dget_space(data.set.get()), path);
    readable(H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, extent.data(), nullptr),
             path);
    const Handle memory = readable(H5Screate_simple(1, &size, nullptr), path);
    readable(H5Dread(data.set.get(), type_of<T>(), memory.get(), space.get(), H5P_DEFAULT, row.data()), path);
}

template std::vector<double> read(hid_t, const std::string&, std::size_t);
template std::vector<std::int64_t> read(hid_t, const std::string&, std::size_t);
template std::vector<std::uint64_t> read(hid_t, const std::string&, std::size_t);
template std::vector<std::int32_t> read(hid_t, const std::string&, std::size_t);
template std::vector<std::uint8_t> read(hid_t, const std::string&, std::size_t);
template void read_row(hid_t, const std::string&, hsize_t, std::span<std::uint8_t>);
template void read_row(hid_t, const std::string&, hsize_t, std::span<std::uint16_t>);

}  // namespace shaker::h5
