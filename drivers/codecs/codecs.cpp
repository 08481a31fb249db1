#include "drivers/codecs/codecs.hpp"

#include <dlfcn.h>

#include <filesystem>

#include "drivers/errors.hpp"

namespace shaker::codecs {
namespace {

/// Beside the program in a build, in lib/shakerd of its prefix where it is installed.
std::filesystem::path module_file() {
    const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe");
    const auto beside = program.parent_path() / "shaker_codecs.so";
    if (std::filesystem::exists(beside)) return beside;
    return program.parent_path().parent_path() / "lib" / "shakerd" / "shaker_codecs.so";
}

const Functions& load() {
    const std::string file = module_file().string();
    void* const module = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);  // never closed
    void* const symbol = module == nullptr ? nullptr : ::dlsym(module, "shaker_codecs");
    if (symbol == nullptr)
        throw DeviceError{"movies, video devices and image files need a module that cannot be loaded: " +
                          std::string{::dlerror()} + "; it is installed with shakerd"};
    return reinterpret_cast<GetFunctions*>(symbol)();  // NOLINT: as dlsym() is defined
}

const Functions& functions() {
    static const Functions& loaded = load();
    return loaded;
}

}  // namespace

void load_now() { functions(); }

std::vector<Marker> find_markers(const std::vector<unsigned char>& grey, int width, int height) {
    return functions().find_markers(grey, width, height);
}

std::unique_ptr<cv::VideoCapture> new_capture() { return functions().new_capture(); }

std::unique_ptr<cv::VideoWriter> open_ffv1(const std::string& file, double rate_hz, cv::Size size) {
    return functions().open_ffv1(file, rate_hz, size);
}

bool has_ffmpeg() { return functions().has_ffmpeg(); }

bool wait_for_picture(const cv::VideoCapture& device, std::chrono::nanoseconds wait) {
    return functions().wait_for_picture(device, wait);
}

MovieStamps movie_stamps(const std::string& file) { return functions().movie_stamps(file); }

std::int64_t image_pages(const std::string& file) { return functions().image_pages(file); }

std::vector<cv::Mat> read_pages(const std::string& file, std::int64_t first, std::int64_t count) {
    std::vector<cv::Mat> pages;
    try {
        pages = functions().read_pages(file, first, count);
    } catch (const cv::Exception& error) {
        throw InputError{file + ": is not an image that can be read: " + error.err};
    }
    if (std::ssize(pages) != count) throw InputError{file + ": is not an image that can be read"};
    for (const cv::Mat& page : pages) {
        if (page.empty()) throw InputError{file + ": is not an image that can be read"};
        if (page.depth() != CV_8U && page.depth() != CV_16U)
            throw InputError{file + ": its pixels are not integers of 8 or 16 bits"};
    }
    return pages;
}

std::vector<unsigned char> jpeg_of(const cv::Mat& grey, int quality) {
    return functions().jpeg_of(grey, quality);
}

}  // namespace shaker::codecs
