#include "tests/support/recording/hdf5_structure.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <string_view>

#include "drivers/recorded/h5/h5.hpp"

namespace shaker::test {

namespace {

/// Bob Jenkins' lookup3 ("hashlittle" from 0), HDF5's checksum of metadata.
std::uint32_t checksum(std::string_view bytes) {
    std::array<std::uint32_t, 3> s;
    s.fill(0xdeadbeefU + static_cast<std::uint32_t>(bytes.size()));
    auto& [a, b, c] = s;
    const auto add = [&](std::string_view part) {
        for (std::size_t i = 0; i < part.size(); ++i)
            s[i / 4] += std::uint32_t{static_cast<unsigned char>(part[i])} << (8 * (i % 4));
    };
    // x -= z, x ^= z rotated, z += y: the six steps of its mixing, each with the next three of a, b, c.
    const auto step = [](std::uint32_t& x, std::uint32_t y, std::uint32_t& z, int by) {
        x -= z;
        x ^= std::rotl(z, by);
        z += y;
    };
    for (; bytes.size() > 12; bytes.remove_prefix(12)) {
        add(bytes.substr(0, 12));
        step(a, b, c, 4);
        step(b, c, a, 6);
        step(c, a, b, 8);
        step(a, b, c, 16);
        step(b, c, a, 19);
        step(c, a, b, 4);
    }
    if (bytes.empty()) return c;
    add(bytes);
    const auto last = [](std::uint32_t& x, std::uint32_t y, int by) { x = (x ^ y) - std::rotl(y, by); };
    last(c, b, 14);
    last(a, c, 11);
    last(b, a, 25);
    last(c, b, 16);
    last(a, c, 4);
    last(b, a, 14);
    last(c, b, 24);
    return c;
}

std::uint32_t little_endian(std::string_view bytes) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i)
        value |= std::uint32_t{static_cast<unsigned char>(bytes[i])} << (8 * i);
    return value;
}

/// Removes the values of one data set from the structural bytes.
void take_out(hid_t set, std::vector<bool>& described) {
    const auto values = [&](haddr_t address, hsize_t bytes) {
        if (address == HADDR_UNDEF) return;
        const auto first = std::min<std::size_t>(address, described.size());
        const auto last = std::min<std::size_t>(address + bytes, described.size());
        std::fill(described.begin() + static_cast<std::ptrdiff_t>(first),
                  described.begin() + static_cast<std::ptrdiff_t>(last), false);
    };
    const h5::Handle create{H5Dget_create_plist(set), "properties"};
    if (H5Pget_layout(create.get()) != H5D_CHUNKED) {
        values(H5Dget_offset(set), H5Dget_storage_size(set));
        return;
    }
    hsize_t chunks = 0;
    const h5::Handle space{H5Dget_space(set), "space"};
    h5::check(H5Dget_num_chunks(set, space.get(), &chunks), "chunks");
    for (hsize_t i = 0; i < chunks; ++i) {
        haddr_t address = 0;
        hsize_t bytes = 0;
        h5::check(H5Dget_chunk_info(set, space.get(), i, nullptr, nullptr, &address, &bytes), "chunk");
        values(address, bytes);
    }
}

std::vector<Stretch> described_in(const std::filesystem::path& file, std::size_t size) {
    std::vector<bool> described(size, true);
    const h5::Handle root = h5::open_file(file);
    h5::check(H5Ovisit2(
                  root.get(), H5_INDEX_NAME, H5_ITER_INC,
                  [](hid_t top, const char* name, const H5O_info_t* info, void* out) -> herr_t {
                      if (info->type != H5O_TYPE_DATASET) return 0;
                      const h5::Handle set{H5Dopen2(top, name, H5P_DEFAULT), name};
                      take_out(set.get(), *static_cast<std::vector<bool>*>(out));
                      return 0;
                  },
                  &described, H5O_INFO_BASIC),
              file.string());
    std::vector<Stretch> stretches;
    for (std::size_t i = 0; i < size; ++i) {
        if (!described[i]) continue;
        if (stretches.empty() || stretches.back().end != i) stretches.push_back({i, i});
        stretches.back().end = i + 1;
    }
    return stretches;
}

/// Finds the end of the block with this signature: the position where its checksum is right.
void add_sealed(std::string_view bytes, std::size_t begin, std::vector<Stretch>& sealed) {
    constexpr std::size_t longest = 8192;
    const std::size_t most = std::min(bytes.size(), begin + longest);
    for (std::size_t end = begin + 12; end <= most; ++end)
        if (checksum(bytes.substr(begin, end - 4 - begin)) == little_endian(bytes.substr(end - 4, 4))) {
            sealed.push_back({begin, end});
            return;
        }
}

}  // namespace

Structure structure_of(const std::filesystem::path& file) {
    std::ifstream in{file, std::ios::binary};
    const std::string bytes{std::istreambuf_iterator<char>{in}, {}};
    Structure structure{.described = described_in(file, bytes.size()), .sealed = {}};
    constexpr std::array<std::string_view, 16> signatures{"\x89HDF", "OHDR", "OCHK", "FRHP", "FHIB", "FSHD",
                                                          "FSSE",    "BTHD", "BTIN", "BTLF", "EAHD", "EAIB",
                                                          "EASB",    "EADB", "FAHD", "FADB"};
    for (const Stretch& s : structure.described)
        for (std::size_t i = s.begin; i + 4 <= s.end; ++i)
            if (std::ranges::find(signatures, std::string_view{bytes}.substr(i, 4)) != signatures.end())
                add_sealed(bytes, i, structure.sealed);
    return structure;
}

void seal(std::string& bytes, const Structure& structure) {
    for (const Stretch& s : structure.sealed) {
        if (s.end > bytes.size()) continue;
        const std::uint32_t sum = checksum(std::string_view{bytes}.substr(s.begin, s.end - 4 - s.begin));
        for (std::size_t i = 0; i < 4; ++i)
            bytes[s.end - 4 + i] = static_cast<char>(static_cast<unsigned char>(sum >> (8 * i)));
    }
}

}  // namespace shaker::test
