#include "drivers/recorded/h5/growing.hpp"

#include <algorithm>

#include "drivers/errors.hpp"
#include "drivers/recorded/h5/crc32c.hpp"

namespace shaker::h5 {

Growing::Growing(hid_t parent, const std::string& name, hid_t type, std::vector<hsize_t> row, hsize_t chunk,
                 const std::string& units)
    : name_{name}, type_{H5Tcopy(type), name}, extent_{std::move(row)} {
    row_bytes_ = H5Tget_size(type);
    for (const hsize_t n : extent_) row_bytes_ *= n;
    chunk_bytes_ = row_bytes_ * chunk;
    extent_.insert(extent_.begin(), 0);
    std::vector<hsize_t> most = extent_, chunks = extent_;
    most[0] = H5S_UNLIMITED;
    chunks[0] = chunk;
    const Handle create{H5Pcreate(H5P_DATASET_CREATE), name};
    check(H5Pset_chunk(create.get(), static_cast<int>(chunks.size()), chunks.data()), name);
    check(H5Pset_obj_track_times(create.get(), false), name);
    const Handle space{H5Screate_simple(static_cast<int>(extent_.size()), extent_.data(), most.data()), name};
    set_ = {H5Dcreate2(parent, name.c_str(), type, space.get(), H5P_DEFAULT, create.get(), H5P_DEFAULT),
            name};
    if (H5Tget_class(type) != H5T_STRING)
        set_attribute(set_.get(), "units", units.empty() ? std::string{"1"} : units);
}

Growing::Growing(hid_t parent, const std::string& path, hsize_t rows, std::uint32_t checksum)
    : name_{path}, set_{H5Dopen2(parent, path.c_str(), H5P_DEFAULT), path}, checksum_{checksum} {
    type_ = {H5Dget_type(set_.get()), path};
    const Handle space{H5Dget_space(set_.get()), path};
    const int rank = H5Sget_simple_extent_ndims(space.get());
    if (rank < 1) throw InputError{"recording: \"" + path + "\" is not a column"};
    std::vector<hsize_t> most(static_cast<std::size_t>(rank));
    extent_.resize(most.size());
    check(H5Sget_simple_extent_dims(space.get(), extent_.data(), most.data()), path);
    if (most[0] != H5S_UNLIMITED) throw InputError{"recording: \"" + path + "\" cannot grow"};
    row_bytes_ = H5Tget_size(type_.get());
    for (std::size_t axis = 1; axis < extent_.size(); ++axis) row_bytes_ *= extent_[axis];
    chunk_bytes_ = row_bytes_;
    const Bytes kept = read_first_bytes(parent, path);
    if (kept.values.size() < rows * row_bytes_)
        throw InputError{"recording: \"" + path + "\" has fewer than " + std::to_string(rows) +
                         " readable rows"};
    if (resize(rows) && takes_rows()) return;
    remake(parent);
    append_bytes(std::span{kept.values}.first(rows * row_bytes_));
    flush();
    checksum_ = checksum;
}

bool Growing::resize(hsize_t rows) noexcept {
    std::vector<hsize_t> extent = extent_;
    extent[0] = rows;
    if (H5Dset_extent(set_.get(), extent.data()) < 0) return false;
    extent_[0] = rows;
    return true;
}

// Tests with one row: a torn index behind the last row is detected when the column grows.
bool Growing::takes_rows() try {
    const hsize_t rows = extent_[0];
    if (!resize(rows + 1)) return false;
    write(rows, std::vector<std::byte>(row_bytes_));
    return resize(rows);
} catch (const DeviceError&) {
    return false;
}

// Creates another data set of the same description under its name. The old one stays unlinked in the file: to
// free it, HDF5 would follow its torn index.
void Growing::remake(hid_t parent) {
    const Handle create{H5Dget_create_plist(set_.get()), name_};
    const std::string units =
        H5Aexists(set_.get(), "units") > 0 ? read_attribute_text(parent, name_, "units") : "";
    check(H5Oincr_refcount(set_.get()), name_);
    check(H5Ldelete(parent, name_.c_str(), H5P_DEFAULT), name_);
    std::vector<hsize_t> most = extent_;
    extent_[0] = 0;
    most[0] = H5S_UNLIMITED;
    const Handle space{H5Screate_simple(static_cast<int>(extent_.size()), extent_.data(), most.data()),
                       name_};
    set_ = {
        H5Dcreate2(parent, name_.c_str(), type_.get(), space.get(), H5P_DEFAULT, create.get(), H5P_DEFAULT),
        name_};
    if (!units.empty()) set_attribute(set_.get(), "units", units);
}

void Growing::clear() {
    extent_[0] = 0;
    waiting_.clear();
    checksum_ = 0;
    check(H5Dset_extent(set_.get(), extent_.data()), name_);
}

void Growing::append_bytes(std::span<const std::byte> rows) {
    checksum_ = crc32c(rows, checksum_);
    waiting_.insert(waiting_.end(), rows.begin(), rows.end());
    if (waiting_.size() >= chunk_bytes_) flush();
}

void Growing::append_text(const std::string& text) {
    std::string row = text.substr(0, row_bytes_);
    row.resize(row_bytes_, '\0');
    append_bytes(std::as_bytes(std::span{row}));
}

hsize_t Growing::rows() const noexcept { return extent_[0] + waiting_.size() / row_bytes_; }

// Rows of the file, and as many in memory.
std::pair<Handle, Handle> Growing::spaces(hsize_t first, hsize_t rows) const {
    std::vector<hsize_t> start(extent_.size(), 0), count = extent_;
    start[0] = first;
    count[0] = rows;
    Handle space{H5Dget_space(set_.get()), name_};
    check(H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr),
          name_);
    return {std::move(space),
            Handle{H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), name_}};
}

void Growing::write(hsize_t first, std::span<const std::byte> rows) {
    const auto [space, memory] = spaces(first, rows.size() / row_bytes_);
    check(H5Dwrite(set_.get(), type_.get(), memory.get(), space.get(), H5P_DEFAULT, rows.data()), name_);
}

void Growing::read_bytes(hsize_t first, std::span<std::byte> rows) {
    if (rows.empty()) return;
    flush();
    const auto [space, memory] = spaces(first, rows.size() / row_bytes_);
    check(H5Dread(set_.get(), type_.get(), memory.get(), space.get(), H5P_DEFAULT, rows.data()), name_);
}

void Growing::flush() {
    if (waiting_.empty()) return;
    const hsize_t first = extent_[0];
    extent_[0] = rows();
    check(H5Dset_extent(set_.get(), extent_.data()), name_);
    write(first, waiting_);
    waiting_.clear();
}

void Growing::replace(std::span<const std::byte> rows) {
    if (!waiting_.empty() || rows.size() != extent_[0] * row_bytes_)
        throw DeviceError{name_ + ": " + std::to_string(rows.size() / row_bytes_) + " rows in place of " +
                          std::to_string(this->rows())};
    if (rows.empty()) return;
    write(0, rows);
    checksum_ = crc32c(rows);
}

}  // namespace shaker::h5
