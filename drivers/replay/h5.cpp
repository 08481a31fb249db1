#include "drivers/replay/h5.hpp"

#include <algorithm>
#include <numeric>

#include "drivers/errors.hpp"

namespace shaker::h5 {

namespace {

// The innermost message of HDF5's error stack: its own words for what went wrong.
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
    return words.empty() ? "unknown HDF5 error" : words;
}

// HDF5 prints its error stack by itself unless told not to; what it says is thrown instead.
void be_quiet() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

Handle plist(hid_t kind) { return {H5Pcreate(kind), "property list"}; }

Handle dataset_at(hid_t parent, const std::string& path) {
    be_quiet();
    const hid_t id = H5Dopen2(parent, path.c_str(), H5P_DEFAULT);
    if (id < 0) throw InputError{"recording has no data set \"" + path + "\": " + own_words()};
    return {id, path};
}

Handle fixed_text(std::size_t size) {
    Handle type{H5Tcopy(H5T_C_S1), "string type"};
    check(H5Tset_size(type.get(), std::max<std::size_t>(1, size)), "string size");
    check(H5Tset_cset(type.get(), H5T_CSET_UTF8), "string character set");
    return type;
}

Handle attribute_at(hid_t parent, const std::string& path, const std::string& name) {
    be_quiet();
    const hid_t id = H5Aopen_by_name(parent, path.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT);
    if (id < 0) throw InputError{"recording has no attribute \"" + name + "\" at \"" + path + "\""};
    return {id, name};
}

std::string trimmed(std::string text) {
    text.resize(std::min(text.size(), text.find('\0')));
    return text;
}

constexpr std::size_t text_limit = 16U << 20U;

}  // namespace

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

template <> hid_t type_of<double>() noexcept { return H5T_NATIVE_DOUBLE; }
template <> hid_t type_of<std::int64_t>() noexcept { return H5T_NATIVE_INT64; }
template <> hid_t type_of<std::uint64_t>() noexcept { return H5T_NATIVE_UINT64; }
template <> hid_t type_of<std::int32_t>() noexcept { return H5T_NATIVE_INT32; }
template <> hid_t type_of<std::uint8_t>() noexcept { return H5T_NATIVE_UINT8; }
template <> hid_t type_of<std::uint16_t>() noexcept { return H5T_NATIVE_UINT16; }

Handle create_file(const std::filesystem::path& file) {
    be_quiet();
    const Handle access = plist(H5P_FILE_ACCESS);
    check(H5Pset_libver_bounds(access.get(), H5F_LIBVER_V18, H5F_LIBVER_LATEST), file.string());
    const Handle create = plist(H5P_FILE_CREATE);
    check(H5Pset_obj_track_times(create.get(), false), file.string());  // of the root group
    return {H5Fcreate(file.c_str(), H5F_ACC_TRUNC, create.get(), access.get()), file.string()};
}

Handle open_file(const std::filesystem::path& file) {
    be_quiet();
    if (!std::filesystem::is_regular_file(file)) throw InputError{file.string() + ": no such file"};
    if (H5Fis_hdf5(file.c_str()) <= 0) throw InputError{file.string() + ": not an HDF5 file"};
    const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    if (id < 0) throw InputError{file.string() + ": cannot be opened: " + own_words()};
    return {id, file.string()};
}

Handle make_group(hid_t parent, const std::string& path, const std::string& nx_class) {
    const Handle create = plist(H5P_GROUP_CREATE);
    check(H5Pset_obj_track_times(create.get(), false), path);  // same content, same bytes
    for (std::size_t end = path.find('/'); end != std::string::npos; end = path.find('/', end + 1)) {
        const std::string above = path.substr(0, end);
        if (H5Lexists(parent, above.c_str(), H5P_DEFAULT) > 0) continue;
        const Handle made{H5Gcreate2(parent, above.c_str(), H5P_DEFAULT, create.get(), H5P_DEFAULT), above};
        set_attribute(made.get(), "NX_class", std::string{"NXcollection"});
    }
    Handle group{H5Gcreate2(parent, path.c_str(), H5P_DEFAULT, create.get(), H5P_DEFAULT), path};
    if (!nx_class.empty()) set_attribute(group.get(), "NX_class", nx_class);
    return group;
}

void set_attribute(hid_t object, const std::string& name, const std::string& text) {
    const Handle type = fixed_text(text.size());
    const Handle space{H5Screate(H5S_SCALAR), name};
    const Handle a{H5Acreate2(object, name.c_str(), type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT), name};
    const std::string padded = text.empty() ? std::string(1, '\0') : text;
    check(H5Awrite(a.get(), type.get(), padded.data()), name);
}

void set_attribute(hid_t object, const std::string& name, const std::vector<std::string>& texts) {
    std::size_t longest = 1;
    for (const std::string& t : texts) longest = std::max(longest, t.size());
    std::string block;
    for (std::string t : texts) {
        t.resize(longest, '\0');
        block += t;
    }
    const Handle type = fixed_text(longest);
    const hsize_t count = texts.size();
    const Handle space{H5Screate_simple(1, &count, nullptr), name};
    const Handle a{H5Acreate2(object, name.c_str(), type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT), name};
    check(H5Awrite(a.get(), type.get(), block.data()), name);
}

void set_attribute(hid_t object, const std::string& name, double value) {
    const Handle space{H5Screate(H5S_SCALAR), name};
    const Handle a{H5Acreate2(object, name.c_str(), H5T_IEEE_F64LE, space.get(), H5P_DEFAULT, H5P_DEFAULT), name};
    check(H5Awrite(a.get(), H5T_NATIVE_DOUBLE, &value), name);
}

void set_attribute(hid_t object, const std::string& name, std::int64_t value) {
    const Handle space{H5Screate(H5S_SCALAR), name};
    const Handle a{H5Acreate2(object, name.c_str(), H5T_STD_I64LE, space.get(), H5P_DEFAULT, H5P_DEFAULT), name};
    check(H5Awrite(a.get(), H5T_NATIVE_INT64, &value), name);
}

template <Element T>
void write(hid_t parent, const std::string& name, std::span<const T> values, std::vector<hsize_t> shape,
           const std::string& units) {
    const Handle create = plist(H5P_DATASET_CREATE);
    check(H5Pset_obj_track_times(create.get(), false), name);
    const Handle space{shape.empty() ? H5Screate(H5S_SCALAR)
                                     : H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr),
                       name};
    const Handle set{
        H5Dcreate2(parent, name.c_str(), type_of<T>(), space.get(), H5P_DEFAULT, create.get(), H5P_DEFAULT), name};
    if (!values.empty()) check(H5Dwrite(set.get(), type_of<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), name);
    if (!units.empty()) set_attribute(set.get(), "units", units);
}

void write_text(hid_t parent, const std::string& name, const std::string& text) {
    const Handle create = plist(H5P_DATASET_CREATE);
    check(H5Pset_obj_track_times(create.get(), false), name);
    const Handle type = fixed_text(text.size());
    const Handle space{H5Screate(H5S_SCALAR), name};
    const Handle set{
        H5Dcreate2(parent, name.c_str(), type.get(), space.get(), H5P_DEFAULT, create.get(), H5P_DEFAULT), name};
    const std::string padded = text.empty() ? std::string(1, '\0') : text;
    check(H5Dwrite(set.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, padded.data()), name);
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
    const Handle group{H5Gopen2(parent, path.c_str(), H5P_DEFAULT), path};
    check(H5Literate(
              group.get(), H5_INDEX_NAME, H5_ITER_INC, nullptr,
              [](hid_t, const char* name, const H5L_info_t*, void* out) -> herr_t {
                  static_cast<std::vector<std::string>*>(out)->emplace_back(name);
                  return 0;
              },
              &names),
          path);
    return names;
}

std::vector<hsize_t> shape_of(hid_t parent, const std::string& path) {
    const Handle set = dataset_at(parent, path);
    const Handle space{H5Dget_space(set.get()), path};
    std::vector<hsize_t> shape(static_cast<std::size_t>(std::max(0, H5Sget_simple_extent_ndims(space.get()))));
    check(H5Sget_simple_extent_dims(space.get(), shape.data(), nullptr), path);
    return shape;
}

template <Element T>
std::vector<T> read(hid_t parent, const std::string& path, std::size_t limit) {
    const Handle set = dataset_at(parent, path);
    const Handle type{H5Dget_type(set.get()), path};
    if (H5Tget_class(type.get()) != H5Tget_class(type_of<T>()))
        throw InputError{"recording: \"" + path + "\" is not of the expected number type"};
    const Handle space{H5Dget_space(set.get()), path};
    const hssize_t count = H5Sget_simple_extent_npoints(space.get());
    if (count < 0 || static_cast<std::size_t>(count) > limit)
        throw InputError{"recording: \"" + path + "\" has " + std::to_string(count) + " elements, at most " +
                         std::to_string(limit) + " are read"};
    std::vector<T> values(static_cast<std::size_t>(count));
    if (!values.empty()) check(H5Dread(set.get(), type_of<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), path);
    return values;
}

std::string read_text(hid_t parent, const std::string& path) {
    const Handle set = dataset_at(parent, path);
    const Handle type{H5Dget_type(set.get()), path};
    const std::size_t size = H5Tget_size(type.get());
    if (H5Tget_class(type.get()) != H5T_STRING || H5Tis_variable_str(type.get()) > 0 || size > text_limit)
        throw InputError{"recording: \"" + path + "\" is not a fixed-length text"};
    std::string text(size, '\0');
    check(H5Dread(set.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()), path);
    return trimmed(std::move(text));
}

std::string read_attribute_text(hid_t parent, const std::string& path, const std::string& name) {
    const Handle a = attribute_at(parent, path, name);
    const Handle type{H5Aget_type(a.get()), name};
    const std::size_t size = H5Tget_size(type.get());
    if (H5Tget_class(type.get()) != H5T_STRING || H5Tis_variable_str(type.get()) > 0 || size > text_limit)
        throw InputError{"recording: attribute \"" + name + "\" at \"" + path + "\" is not a fixed-length text"};
    std::string text(size, '\0');
    check(H5Aread(a.get(), type.get(), text.data()), name);
    return trimmed(std::move(text));
}

double read_attribute(hid_t parent, const std::string& path, const std::string& name) {
    const Handle a = attribute_at(parent, path, name);
    const Handle space{H5Aget_space(a.get()), name};
    if (H5Sget_simple_extent_npoints(space.get()) != 1)
        throw InputError{"recording: attribute \"" + name + "\" at \"" + path + "\" is not one number"};
    double value = 0;
    check(H5Aread(a.get(), H5T_NATIVE_DOUBLE, &value), name);
    return value;
}

template <Element T>
void read_row(hid_t parent, const std::string& path, hsize_t index, std::span<T> row) {
    const Handle set = dataset_at(parent, path);
    const Handle space{H5Dget_space(set.get()), path};
    std::vector<hsize_t> extent(static_cast<std::size_t>(std::max(1, H5Sget_simple_extent_ndims(space.get()))));
    check(H5Sget_simple_extent_dims(space.get(), extent.data(), nullptr), path);
    std::vector<hsize_t> start(extent.size(), 0);
    start[0] = index;
    const hsize_t rows = std::exchange(extent[0], 1);
    const hsize_t size = std::accumulate(extent.begin(), extent.end(), hsize_t{1}, std::multiplies<>{});
    if (index >= rows || size != row.size())
        throw InputError{"recording: \"" + path + "\" has no row " + std::to_string(index) + " of the expected size"};
    check(H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, extent.data(), nullptr), path);
    const Handle memory{H5Screate_simple(1, &size, nullptr), path};
    check(H5Dread(set.get(), type_of<T>(), memory.get(), space.get(), H5P_DEFAULT, row.data()), path);
}

template <Element T>
Appender<T>::Appender(hid_t parent, const std::string& name, std::vector<hsize_t> row, hsize_t chunk,
                      const std::string& units)
    : extent_{std::move(row)}, chunk_rows_{static_cast<std::size_t>(chunk)} {
    row_size_ = std::accumulate(extent_.begin(), extent_.end(), std::size_t{1}, std::multiplies<>{});
    extent_.insert(extent_.begin(), 0);
    std::vector<hsize_t> most = extent_, chunks = extent_;
    most[0] = H5S_UNLIMITED;
    chunks[0] = chunk;
    const Handle create = plist(H5P_DATASET_CREATE);
    check(H5Pset_chunk(create.get(), static_cast<int>(chunks.size()), chunks.data()), name);
    check(H5Pset_obj_track_times(create.get(), false), name);
    const Handle space{H5Screate_simple(static_cast<int>(extent_.size()), extent_.data(), most.data()), name};
    set_ = {H5Dcreate2(parent, name.c_str(), type_of<T>(), space.get(), H5P_DEFAULT, create.get(), H5P_DEFAULT),
            name};
    if (!units.empty()) set_attribute(set_.get(), "units", units);
    waiting_.reserve(row_size_ * chunk_rows_);
}

template <Element T>
void Appender<T>::append(std::span<const T> rows) {
    waiting_.insert(waiting_.end(), rows.begin(), rows.end());
    if (waiting_.size() >= row_size_ * chunk_rows_) flush();
}

template <Element T>
void Appender<T>::flush() {
    if (waiting_.empty()) return;
    std::vector<hsize_t> start(extent_.size(), 0), count = extent_;
    start[0] = extent_[0];
    count[0] = waiting_.size() / row_size_;
    extent_[0] += count[0];
    check(H5Dset_extent(set_.get(), extent_.data()), "growing a stream");
    const Handle space{H5Dget_space(set_.get()), "stream"};
    check(H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr), "stream");
    const Handle memory{H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), "stream"};
    check(H5Dwrite(set_.get(), type_of<T>(), memory.get(), space.get(), H5P_DEFAULT, waiting_.data()), "stream");
    waiting_.clear();
}

template class Appender<double>;
template class Appender<std::int64_t>;
template class Appender<std::int32_t>;
template class Appender<std::uint8_t>;
template class Appender<std::uint16_t>;
template void write(hid_t, const std::string&, std::span<const double>, std::vector<hsize_t>, const std::string&);
template void write(hid_t, const std::string&, std::span<const std::int64_t>, std::vector<hsize_t>,
                    const std::string&);
template void write(hid_t, const std::string&, std::span<const std::uint64_t>, std::vector<hsize_t>,
                    const std::string&);
template std::vector<double> read(hid_t, const std::string&, std::size_t);
template std::vector<std::int64_t> read(hid_t, const std::string&, std::size_t);
template std::vector<std::uint64_t> read(hid_t, const std::string&, std::size_t);
template std::vector<std::int32_t> read(hid_t, const std::string&, std::size_t);
template std::vector<std::uint8_t> read(hid_t, const std::string&, std::size_t);
template void read_row(hid_t, const std::string&, hsize_t, std::span<std::int32_t>);
template void read_row(hid_t, const std::string&, hsize_t, std::span<std::uint8_t>);
template void read_row(hid_t, const std::string&, hsize_t, std::span<std::uint16_t>);

}  // namespace shaker::h5
