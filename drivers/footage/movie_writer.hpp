#pragma once
// Writes a movie that loses no grey value.
#include <filesystem>
#include <memory>

#include "drivers/data.hpp"

namespace shaker::footage {

/// Matroska with FFV1, 8-bit grey: open_movie() gives the same pixels. One thread.
class MovieWriter {
public:
    /// Throws DeviceError naming the file when it cannot be written.
    MovieWriter(const std::filesystem::path& file, int width, int height, double rate_hz);
    ~MovieWriter();
    MovieWriter(MovieWriter&&) noexcept;
    MovieWriter& operator=(MovieWriter&&) noexcept;
    /// The next picture, of 1 byte a pixel and the movie's size.
    void write(const ImageView& picture);

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace shaker::footage
