#include <algorithm>

#include "drivers/errors.hpp"
#include "drivers/recorded/recording_streams.hpp"

namespace shaker::recorded {

namespace {

const std::string samples = path_of(raw::counts);

// Columns with equal numbers of rows: those of a group, and all of a camera.
std::string family_of(const std::string& path) {
    std::string parent = path.substr(0, path.rfind('/'));
    if (parent.starts_with("tracks/")) return "raw/" + parent.substr(7, parent.find('/', 7) - 7);
    return parent;
}

// The verified part of a column.
struct Vouched {
    h5::Bytes bytes;
    hsize_t rows = 0;

    [[nodiscard]] std::uint32_t checksum() const {
        return h5::crc32c(std::span{bytes.values}.first(rows * bytes.row));
    }
};

Vouched vouched(hid_t entry, const h5::SealedColumn& column) {
    Vouched v{h5::read_first_bytes(entry, column.path), 0};
    v.rows = column.good_rows(v.bytes.values, v.bytes.row);
    return v;
}

// Matches blocks and samples: cuts both to whole blocks whose samples exist.
void match_blocks(Vouched& counts, hsize_t& blocks, const Vouched& size) {
    hsize_t rows = 0, whole = 0;
    for (; whole < blocks; ++whole) {
        const hsize_t next = rows + std::to_integer<hsize_t>(size.bytes.values[whole]);
        if (next > counts.rows) break;
        rows = next;
    }
    blocks = whole;
    counts.rows = rows;
}

}  // namespace

void RecordingWriter::Streams::mend() {
    const std::vector<h5::SealedColumn> sealed = h5::read_seals(entry.get());
    std::vector<Vouched> good;
    std::map<std::string, hsize_t> rows_of;  // per family
    for (const h5::SealedColumn& c : sealed) {
        good.push_back(vouched(entry.get(), c));
        if (c.path == samples || h5::description_of(entry.get(), c.path).shape.empty()) continue;
        const auto [at, first] = rows_of.try_emplace(family_of(c.path), good.back().rows);
        if (!first) at->second = std::min(at->second, good.back().rows);
    }
    const auto index = [&](const std::string& path) {
        const auto at = std::ranges::find(sealed, path, &h5::SealedColumn::path);
        if (at == sealed.end()) throw InputError{"recording: its seals do not cover \"" + path + "\""};
        return static_cast<std::size_t>(at - sealed.begin());
    };
    match_blocks(good[index(samples)], rows_of[raw::accelerometer], good[index(path_of(raw::block_size))]);
    for (std::size_t k = 0; k < sealed.size(); ++k) {
        const std::string& path = sealed[k].path;
        columns.push_back(path);
        if (h5::description_of(entry.get(), path).shape.empty()) {
            reopen_once(path, good[k].rows == 1 ? std::optional{good[k].checksum()} : std::nullopt);
            continue;
        }
        if (path != samples) good[k].rows = rows_of[family_of(path)];
        const bool provisional = std::ranges::any_of(sealed[k].pieces, [](const h5::SealedPiece& p) {
            return p.checksum == h5::SealEntry::unchecked;
        });
        growing.push_back({{entry.get(), path, good[k].rows, good[k].checksum()}, k, provisional});
        by_path[path] = &growing.back();
    }
    seals.emplace(entry.get(), columns.size());
}

void RecordingWriter::Streams::reopen_once(const std::string& path, std::optional<std::uint32_t> checksum) {
    h5::Handle set{H5Dopen2(entry.get(), path.c_str(), H5P_DEFAULT), path};
    h5::Handle type{H5Dget_type(set.get()), path};
    if (!checksum) {  // as if it had not been written
        std::string empty(H5Tget_size(type.get()), '\0');
        const double unknown = std::numeric_limits<double>::quiet_NaN();
        const void* value =
            H5Tget_class(type.get()) == H5T_STRING ? static_cast<const void*>(empty.data()) : &unknown;
        h5::check(H5Dwrite(set.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, value), path);
    }
    once.emplace(path, Once{std::move(set), std::move(type), columns.size() - 1,
                            checksum ? hsize_t{1} : hsize_t{0}, checksum ? std::int64_t{*checksum} : 0});
}

}  // namespace shaker::recorded
