#include "drivers/footage/movie_writer.hpp"

#include <opencv2/imgproc.hpp>

#include "drivers/codecs/codecs.hpp"
#include "drivers/errors.hpp"

namespace shaker::footage {

struct MovieWriter::Impl {
    std::unique_ptr<cv::VideoWriter> movie;
    cv::Mat colour;
};

MovieWriter::MovieWriter(const std::filesystem::path& file, int width, int height, double rate_hz)
    : impl_{std::make_unique<Impl>()} {
    // Three equal colours: FFV1 stores their differences, which are zero, and some builds of OpenCV write no
    // grey.
    impl_->movie = codecs::open_ffv1(file.string(), rate_hz, {width, height});
    if (impl_->movie == nullptr) throw DeviceError{file.string() + ": this movie cannot be written"};
}

MovieWriter::~MovieWriter() = default;
MovieWriter::MovieWriter(MovieWriter&&) noexcept = default;
MovieWriter& MovieWriter::operator=(MovieWriter&&) noexcept = default;

void MovieWriter::write(const ImageView& picture) {
    // OpenCV's matrices do not own these pixels and do not change them.
    const cv::Mat grey{
        picture.height, picture.width, CV_8UC1,
        const_cast<std::byte*>(picture.pixels),  // NOLINT(cppcoreguidelines-pro-type-const-cast)
        static_cast<std::size_t>(picture.stride)};
    cv::cvtColor(grey, impl_->colour, cv::COLOR_GRAY2BGR);
    impl_->movie->write(impl_->colour);
}

}  // namespace shaker::footage
