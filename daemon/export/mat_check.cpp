#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <memory>

#include "daemon/export/files.hpp"
#include "drivers/errors.hpp"

namespace shaker::exporting {

namespace {

constexpr std::size_t header_bytes = 128;
constexpr std::uint32_t compressed = 15;  // element type of compressed data

// True if the next `bytes` are one zlib stream with a valid checksum.
bool is_whole(std::ifstream& in, std::size_t bytes) {
    z_stream stream{};
    if (inflateInit(&stream) != Z_OK) return false;
    const std::unique_ptr<z_stream, decltype(&inflateEnd)> end{&stream, &inflateEnd};
    std::array<char, 65536> read{}, ignored{};
    int state = Z_OK;
    while (bytes > 0 && state == Z_OK) {
        const std::size_t n = std::min(bytes, read.size());
        if (!in.read(read.data(), static_cast<std::streamsize>(n))) return false;
        bytes -= n;
        stream.next_in = reinterpret_cast<Bytef*>(read.data());
        stream.avail_in = static_cast<uInt>(n);
        while (state == Z_OK && (stream.avail_in > 0 || stream.avail_out == 0)) {
            stream.next_out = reinterpret_cast<Bytef*>(ignored.data());
            stream.avail_out = static_cast<uInt>(ignored.size());
            state = inflate(&stream, Z_NO_FLUSH);
        }
        if (state == Z_BUF_ERROR) state = Z_OK;  // the input so far is consumed
    }
    return state == Z_STREAM_END && bytes == 0 && stream.avail_in == 0;
}

}  // namespace

// libmatio does not report a full disk.
void require_whole_mat(const std::filesystem::path& file, std::size_t variables) {
    std::ifstream in{file, std::ios::binary};
    in.seekg(header_bytes);
    std::size_t whole = 0;
    std::array<std::uint32_t, 2> tag{};
    std::array<char, sizeof tag> bytes{};
    while (in.read(bytes.data(), bytes.size())) {
        std::memcpy(tag.data(), bytes.data(), bytes.size());
        if (tag[0] != compressed || !is_whole(in, tag[1])) break;
        ++whole;
    }
    if (whole != variables)
        throw DeviceError{file.string() + ": only " + std::to_string(whole) + " of " +
                          std::to_string(variables) + " tables could be written: is the disk full?"};
}

}  // namespace shaker::exporting
