#include "drivers/footage/media.hpp"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <utility>

#include "drivers/codecs/codecs.hpp"
#include "drivers/errors.hpp"

namespace shaker::footage {
namespace {

/// Containers of other programs, which their own software can save in a form that is read here.
constexpr std::array<std::pair<std::string_view, std::string_view>, 8> others{{
    {".seq", "StreamPix (NorPix)"},
    {".r3d", "RED"},
    {".braw", "Blackmagic RAW"},
    {".ser", "SER (astronomy)"},
    {".nd2", "Nikon NIS"},
    {".lif", "Leica LAS"},
    {".czi", "Zeiss ZEN"},
    {".raw", "an unknown camera, without a header,"},
}};

}  // namespace

std::string lower(std::string text) {
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

void unpack_pixels(const std::vector<std::byte>& packed, unsigned bits, std::vector<std::byte>& pixels) {
    std::uint32_t window = 0;
    unsigned held = 0;
    std::size_t at = 0;
    for (std::size_t i = 0; i + 1 < pixels.size(); i += 2) {
        while (held < bits) {
            window = (window << 8U) | std::to_integer<std::uint32_t>(packed[at++]);
            held += 8;
        }
        held -= bits;
        const auto grey = static_cast<std::uint16_t>((window >> held) & ((1U << bits) - 1U));
        std::memcpy(&pixels[i], &grey, sizeof grey);
    }
}

std::vector<std::filesystem::path> media_files(const std::filesystem::path& file) {
    std::vector<std::filesystem::path> files{file};
    if (!are_images(file)) {
        if (lower(file.extension().string()) == ".cih")
            for (const char* extension : raw_extensions)
                files.push_back(std::filesystem::path{file}.replace_extension(extension));
        return files;
    }
    if (std::filesystem::is_regular_file(file)) return files;
    if (!std::filesystem::is_directory(file))
        files.front() = file.has_parent_path() ? file.parent_path() : std::filesystem::path{"."};
    try {
        for (auto& image : image_files(file, MissingNumbers::left_out)) files.push_back(std::move(image));
    } catch (const std::exception&) {  // reported when it is opened
    }
    return files;
}

void load_decoders() noexcept {
    try {
        (void)codecs::has_ffmpeg();
    } catch (const std::exception&) {  // reported when it is needed
    }
}

std::unique_ptr<Media> open_media(const std::filesystem::path& file, MissingNumbers missing) {
    const std::string extension = lower(file.extension().string());
    if (are_images(file)) return open_images(file, missing);
    if (!std::filesystem::exists(file)) throw InputError{file.string() + ": No such file or directory"};
    if (extension == ".cih") return open_photron(file);
    if (extension == ".cine") return open_phantom(file);
    if (extension == ".mraw" || extension == ".cihx")
        throw InputError{file.string() +
                         ": give the text header of this Photron recording, its .cih file, instead"};
    for (const auto& [ending, program] : others)
        if (extension == ending)
            throw InputError{
                file.string() + ": pictures of " + std::string{program} +
                " cannot be read; save them as TIFF, PNG, or a movie without losses (FFV1), with "
                "the times of the pictures as a table"};
    return open_movie(file);
}

}  // namespace shaker::footage
