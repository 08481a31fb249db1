#include "drivers/recorded/h5/seals.hpp"

#include <algorithm>
#include <cstring>

#include "drivers/errors.hpp"
#include "drivers/recorded/h5/crc32c.hpp"

namespace shaker::h5 {

namespace {

constexpr hsize_t seal_chunk = 4096;
constexpr const char* group = "seals/";

std::uint32_t checksum_of(std::span<const SealEntry> entries) { return crc32c(std::as_bytes(entries)); }

h5::Growing column(hid_t entry, const char* name) {
    return {entry, std::string{group} + name, H5T_NATIVE_INT64, {}, seal_chunk, "1"};
}

std::vector<SealEntry> read_entries(hid_t entry) {
    const auto read = [&](const char* name) {  // a torn index may hide the last entries
        const h5::Bytes bytes = h5::read_first_bytes(entry, std::string{group} + name);
        if (bytes.row != sizeof(std::int64_t))
            throw InputError{std::string{"recording: \""} + group + name +
                             "\" is not a column of 64-bit numbers"};
        std::vector<std::int64_t> values(bytes.values.size() / sizeof(std::int64_t));
        if (!values.empty()) std::memcpy(values.data(), bytes.values.data(), bytes.values.size());
        return values;
    };
    const auto seal = read("seal"), column = read("column"), rows = read("rows"), checksum = read("checksum");
    // After a crash the columns may differ in length.
    const std::size_t n = std::min({seal.size(), column.size(), rows.size(), checksum.size()});
    std::vector<SealEntry> entries(n);
    for (std::size_t i = 0; i < n; ++i) entries[i] = {seal[i], column[i], rows[i], checksum[i]};
    return entries;
}

// Converts the entries of one seal to pieces; false when they are inconsistent.
bool take(std::vector<SealedColumn>& columns, std::span<const SealEntry> entries) {
    for (const SealEntry& e : entries) {
        if (e.column < 0 || static_cast<std::size_t>(e.column) >= columns.size()) return false;
        auto& pieces = columns[static_cast<std::size_t>(e.column)].pieces;
        const hsize_t from = pieces.empty() ? 0 : pieces.back().to;
        if (e.rows < 0 || static_cast<hsize_t>(e.rows) <= from) return false;
        pieces.push_back({from, static_cast<hsize_t>(e.rows), e.checksum, e.seal});
    }
    return true;
}

}  // namespace

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

SealWriter::SealWriter(hid_t entry, const std::vector<std::string>& columns)
    : seal_{((void)h5::make_group(entry, "seals", "NXcollection"), column(entry, "seal"))},
      column_{column(entry, "column")},
      rows_{column(entry, "rows")},
      checksum_{column(entry, "checksum")},
      sealed_(columns.size(), 0) {
    h5::write_texts(entry, std::string{group} + "columns", columns);
}

SealWriter::SealWriter(hid_t entry, std::size_t columns)
    : seal_{entry, std::string{group} + "seal", 0, 0},
      column_{entry, std::string{group} + "column", 0, 0},
      rows_{entry, std::string{group} + "rows", 0, 0},
      checksum_{entry, std::string{group} + "checksum", 0, 0},
      sealed_(columns, 0) {}

void SealWriter::add(std::size_t column, hsize_t rows, std::int64_t checksum) {
    if (rows == sealed_[column]) return;
    sealed_[column] = rows;
    entries_.push_back(
        {number_ + 1, static_cast<std::int64_t>(column), static_cast<std::int64_t>(rows), checksum});
}

void SealWriter::flush() {
    if (entries_.empty()) return;
    ++number_;
    entries_.push_back({number_, SealEntry::whole, static_cast<std::int64_t>(entries_.size()),
                        std::int64_t{checksum_of(entries_)}});
    for (const SealEntry& e : entries_) {
        seal_.append(e.seal);
        column_.append(e.column);
        rows_.append(e.rows);
        checksum_.append(e.checksum);
    }
    entries_.clear();
    for (h5::Growing* g : {&seal_, &column_, &rows_, &checksum_}) g->flush();
}

hsize_t SealedColumn::good_rows(std::span<const std::byte> bytes, std::size_t row_bytes) const {
    hsize_t good = 0;
    for (const SealedPiece& p : pieces) {
        if (p.to * row_bytes > bytes.size()) break;
        const auto piece = bytes.subspan(p.from * row_bytes, (p.to - p.from) * row_bytes);
        if (p.checksum != SealEntry::unchecked && p.checksum != std::int64_t{crc32c(piece)}) break;
        good = p.to;
    }
    return good;
}

std::vector<SealedColumn> read_seals(hid_t entry) {
    std::vector<SealedColumn> columns;
    for (std::string& path : h5::read_texts(entry, std::string{group} + "columns"))
        columns.push_back({std::move(path), {}});
    const std::vector<SealEntry> entries = read_entries(entry);
    std::size_t begin = 0;
    for (std::int64_t seal = 1; begin < entries.size(); ++seal) {
        const auto end = std::find_if(entries.begin() + static_cast<std::ptrdiff_t>(begin), entries.end(),
                                      [](const SealEntry& e) { return e.column == SealEntry::whole; });
        if (end == entries.end()) break;
        const std::span<const SealEntry> of_seal{&entries[begin],
                                                 static_cast<std::size_t>(end - entries.begin()) - begin};
        const bool whole = end->seal == seal && end->rows == static_cast<std::int64_t>(of_seal.size()) &&
                           end->checksum == std::int64_t{checksum_of(of_seal)};
        if (!whole || !take(columns, of_seal)) break;
        begin += of_seal.size() + 1;
    }
    return columns;
}

}  // namespace shaker::h5
