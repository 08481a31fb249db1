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
