#include <algorithm>
#include <limits>
#include <optional>

#include "drivers/errors.hpp"
#include "drivers/recorded/h5/h5.hpp"

namespace shaker::h5 {

namespace {

constexpr std::size_t text_limit = 16U << 20U;

hsize_t file_size(hid_t object, const std::string& path) {
    const Handle file = readable(H5Iget_file_id(object), path);
    hsize_t size = 0;
    readable(H5Fget_filesize(file.get(), &size), path);
    return size;
}

/// a b, or empty above `most`.
std::optional<hsize_t> product(hsize_t a, hsize_t b, hsize_t most) {
    if (b != 0 && a > most / b) return std::nullopt;
    return a * b;
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

/// Bytes of a shape; refused when there are more than `most`.
hsize_t bytes_of(const std::vector<hsize_t>& shape, hsize_t element, hsize_t most, const std::string& path) {
    std::optional<hsize_t> bytes = element;
    for (const hsize_t n : shape) bytes = bytes ? product(*bytes, n, most) : bytes;
    if (!bytes) refuse(path, "states a size larger than the file");
    return *bytes;
}

/// Refuses chunks in rows `first` to `last` (exclusive) whose length in the file differs from their shape:
/// HDF5 1.10 allocates by the one and copies by the other. Only the old index stores the length; in indexes
/// of later formats the library would search the whole index for each chunk, for any stated length.
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
            refuse(path, "has a chunk whose size differs from its shape");
        std::size_t axis = at.size() - 1;
        while ((at[axis] += chunk[axis]) >= data.shape[axis] && axis > 0) at[axis--] = 0;
    }
}

/// Number of elements of a data set. Rows `first` to `last` (exclusive, or the end) are safe to read
/// afterwards.
std::size_t counted(const Opened& data, const std::string& path, hsize_t first = 0,
                    hsize_t last = std::numeric_limits<hsize_t>::max()) {
    const Handle create = readable(H5Dget_create_plist(data.set.get()), path);
    const H5D_layout_t layout = H5Pget_layout(create.get());
    if (layout == H5D_VIRTUAL || H5Pget_external_count(create.get()) != 0)
        refuse(path, "is stored in other files");
    if (H5Pget_nfilters(create.get()) != 0) refuse(path, "is compressed; recordings of shakerd are not");
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
    } else if (const hsize_t stored = H5Dget_storage_size(data.set.get()); stored != 0 && stored != bytes) {
        refuse(path, "is stored in " + std::to_string(stored) + " bytes, but its shape requires " +
                         std::to_string(bytes));
    }
    return static_cast<std::size_t>(bytes / element);
}

/// Same class, size and bit layout, in either byte order.
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

}  // namespace

Description description_of(hid_t parent, const std::string& path) {
    Opened data = opened(parent, path);
    counted(data, path, 0, 0);  // the rows are checked when they are read
    return {std::move(data.shape), H5Tget_size(data.type.get())};
}

template <Element T>
std::vector<T> read(hid_t parent, const std::string& path, std::size_t limit) {
    const Opened data = opened(parent, path);
    expect_type<T>(data, path);
    const std::size_t count = counted(data, path);
    if (count > limit)
        refuse(path, "has " + std::to_string(count) + " elements; limit " + std::to_string(limit));
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

namespace {

/// Rows of a data set up to `last` (exclusive).
Bytes bytes_before(const Opened& data, const std::string& path, hsize_t last) {
    const H5T_class_t kind = H5Tget_class(data.type.get());
    if (kind == H5T_STRING)
        expect_text(data.type.get(), path);
    else if (kind != H5T_INTEGER && kind != H5T_FLOAT)
        refuse(path, "is neither numbers nor text");
    Bytes bytes;
    bytes.row = H5Tget_size(data.type.get());
    bytes.values.resize(counted(data, path, 0, last) * bytes.row);
    for (std::size_t axis = 1; axis < data.shape.size(); ++axis) bytes.row *= data.shape[axis];
    if (!data.shape.empty() && last < data.shape[0]) bytes.values.resize(last * bytes.row);
    if (bytes.values.empty()) return bytes;
    const Handle space = readable(H5Dget_space(data.set.get()), path);
    std::vector<hsize_t> first(data.shape.size(), 0), extent = data.shape;
    if (!extent.empty()) {
        extent[0] = std::min(last, extent[0]);
        readable(
            H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, first.data(), nullptr, extent.data(), nullptr),
            path);
    }
    const Handle memory =
        readable(H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr), path);
    readable(
        H5Dread(data.set.get(), data.type.get(), memory.get(), space.get(), H5P_DEFAULT, bytes.values.data()),
        path);
    return bytes;
}

}  // namespace

Bytes read_bytes(hid_t parent, const std::string& path) {
    return bytes_before(opened(parent, path), path, std::numeric_limits<hsize_t>::max());
}

Bytes read_first_bytes(hid_t parent, const std::string& path) {
    const Opened data = opened(parent, path);
    if (data.shape.empty()) return bytes_before(data, path, 1);
    const auto rows = [&](hsize_t last) -> std::optional<Bytes> {
        try {
            return bytes_before(data, path, last);
        } catch (const InputError&) {
            return std::nullopt;
        }
    };
    if (auto all = rows(data.shape[0])) return std::move(*all);
    hsize_t can = 0, cannot = data.shape[0];
    while (cannot - can > 1) {
        const hsize_t middle = can + (cannot - can) / 2;
        (rows(middle) ? can : cannot) = middle;
    }
    return bytes_before(data, path, can);
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

}  // namespace shaker::h5
