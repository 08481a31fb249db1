#include "drivers/footage/media.hpp"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "tests/support/recording/recording_folder.hpp"

namespace shaker::footage {
namespace {

using namespace test;

constexpr int width = 12, height = 6;

std::vector<Picture> all_pictures(Media& media) {
    std::vector<Picture> pictures;
    for (Picture picture; media.next(picture);) pictures.push_back(picture);
    return pictures;
}

unsigned value_at(const Picture& picture, const PictureFormat& format, int x, int y) {
    const auto index =
        static_cast<std::size_t>(y * format.width + x) * static_cast<std::size_t>(format.bytes_per_pixel);
    std::uint16_t value = 0;
    std::memcpy(&value, &picture.pixels.at(index), static_cast<std::size_t>(format.bytes_per_pixel));
    return value;
}

void expect_pictures(Media& media, const std::vector<int>& numbers, unsigned bits) {
    const PictureFormat format = media.format();
    EXPECT_EQ(format, (PictureFormat{width, height, bits == 8 ? 1 : 2}));
    const auto pictures = all_pictures(media);
    ASSERT_EQ(pictures.size(), numbers.size());
    for (std::size_t k = 0; k < pictures.size(); ++k)
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                ASSERT_EQ(value_at(pictures[k], format, x, y), grey(numbers[k], x, y, bits))
                    << "picture " << k << " at " << x << ", " << y;
}

std::unique_ptr<Media> open(const std::filesystem::path& file) {
    return open_media(file, MissingNumbers::refused);
}

TEST(ImagesTest, ReadsPatternFromLowestNumberWithAllBits) {
    for (const unsigned bits : {8U, 16U})
        for (const int first : {0, 1, 7}) {
            const SessionFolder folder;
            for (int k = 0; k < 4; ++k) {
                const std::string digits = std::to_string(first + k);
                folder.write("img_" + std::string(5 - digits.size(), '0') + digits + ".pgm",
                             pgm(k, width, height, bits));
            }
            const auto media = open(folder / "img_%05d.pgm");
            EXPECT_EQ(media->count(), 4);
            EXPECT_FALSE(media->rate_hz());
            expect_pictures(*media, {0, 1, 2, 3}, bits);
        }
}

TEST(ImagesTest, SixteenBitPngKeepsItsBits) {
    const SessionFolder folder;
    for (int k = 0; k < 2; ++k) {
        cv::Mat image(height, width, CV_16UC1);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                image.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(grey(k, x, y, 16));
        cv::imwrite((folder / ("p" + std::to_string(k) + ".png")).string(), image);
    }
    expect_pictures(*open(folder / "p%d.png"), {0, 1}, 16);
}

TEST(ImagesTest, RecoversGreyStoredAsColour) {
    const SessionFolder folder;
    cv::Mat image(height, width, CV_8UC3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const auto value = static_cast<std::uint8_t>(grey(0, x, y, 8));
            image.at<cv::Vec3b>(y, x) = {value, value, value};
        }
    cv::imwrite((folder / "p0.png").string(), image);
    expect_pictures(*open(folder / "p%d.png"), {0}, 8);
}

TEST(ImagesTest, ReadsFolderInNaturalOrder) {
    const SessionFolder folder;
    for (const int k : {2, 10, 1, 100})
        folder.write("img" + std::to_string(k) + ".pgm", pgm(k, width, height, 8));
    folder.write("notes.txt", "not an image");
    expect_pictures(*open(folder / ""), {1, 2, 10, 100}, 8);
}

TEST(ImagesTest, NamesMissingNumberUnlessAllowed) {
    const SessionFolder folder;
    for (const int k : {3, 4, 6})
        folder.write("img_0" + std::to_string(k) + ".pgm", pgm(k, width, height, 8));
    const auto pattern = folder / "img_%02d.pgm";
    expect_in(refusal([&] { open(pattern); }), {"img_05.pgm: is missing", "img_06.pgm exists", "times"});
    expect_pictures(*open_media(pattern, MissingNumbers::left_out), {3, 4, 6}, 8);
}

TEST(ImagesTest, BadSequencesAreRefusedByName) {
    const SessionFolder folder;
    folder.write("a0.pgm", pgm(0, width, height, 8));
    folder.write("a1.pgm", pgm(1, width, height + 1, 8));
    folder.write("b0.png", "this is not an image");
    const auto media = open(folder / "a%d.pgm");
    expect_in(refusal([&] { all_pictures(*media); }), {"a1.pgm", "12 x 7 pixels of 8 bits", "12 x 6"});
    expect_in(refusal([&] { open(folder / "b%d.png"); }), {"b0.png", "not an image"});
    expect_in(refusal([&] { open(folder / "c%d.png"); }), {"c%d.png", "no file matches this pattern"});
    expect_in(refusal([&] { open(folder / "a%s.pgm"); }), {"a%s.pgm", "unknown pattern"});
    expect_in(refusal([&] { open(folder / "a%d%d.pgm"); }), {"a%d%d.pgm", "unknown pattern"});
    expect_in(refusal([&] { open(folder / "nowhere.mkv"); }), {"nowhere.mkv", "No such file"});
    std::filesystem::create_directory(folder / "empty");
    expect_in(refusal([&] { open(folder / "empty"); }), {"empty", "no images"});
}

std::string cih(int frames, unsigned bits, const std::string& more = "") {
    return "#Camera Information Header\r\n" + more +
           "Record Rate(fps) : 15000\r\nTotal Frame : " + std::to_string(frames) +
           "\r\nImage Width : " + std::to_string(width) + "\r\nImage Height : " + std::to_string(height) +
           "\r\nColor Type : Mono\r\nColor Bit : " + std::to_string(bits) +
           "\r\nFile Format : MRaw\r\nEffectiveBit Depth : 12\r\nEffectiveBit Side : Lower\r\nEND\r\n" +
           "Total Frame : 9999\r\n";
}

/// Packed pixels through text of zeros and ones, so that the test does not share the reader's arithmetic.
std::string packed_picture(int picture, unsigned bits) {
    std::string ones, bytes;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (unsigned b = bits; b-- > 0;)
                ones += ((grey(picture, x, y, bits) >> b) & 1U) != 0 ? '1' : '0';
    for (std::size_t i = 0; i < ones.size(); i += 8)
        bytes += static_cast<char>(std::stoi(ones.substr(i, 8), nullptr, 2));
    return bytes;
}

std::string mraw(int frames, unsigned bits) {
    std::string text;
    for (int k = 0; k < frames; ++k) {
        if (bits == 10 || bits == 12) {
            text += packed_picture(k, bits);
            continue;
        }
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                text += little_endian(grey(k, x, y, bits), static_cast<int>(bits / 8));
    }
    return text;
}

TEST(PhotronTest, PicturesOfAllDepthsAreReadWithAllBits) {
    for (const unsigned bits : {8U, 10U, 12U, 16U}) {
        const SessionFolder folder;
        folder.write("run.mraw", mraw(3, bits));
        const auto media = open(folder.write("run.cih", cih(3, bits)));
        EXPECT_EQ(media->rate_hz(), 15000.0);
        EXPECT_EQ(media->count(), 3);
        expect_pictures(*media, {0, 1, 2}, bits);
    }
}

TEST(PhotronTest, RefusesTruncatedRecordingWithBothCounts) {
    const SessionFolder folder;
    folder.write("run.mraw", mraw(3, 12).substr(0, 250));
    expect_in(refusal([&] { open(folder.write("run.cih", cih(3, 12))); }),
              {"run.mraw: is cut short", "250 bytes hold 2 pictures", "run.cih promises 3"});
}

TEST(PhotronTest, BadHeadersAreRefusedByKeyAndValue) {
    const SessionFolder folder;
    folder.write("run.mraw", mraw(1, 8));
    const auto attempt = [&](const std::string& text) {
        return refusal([&] { open(folder.write("run.cih", text)); });
    };
    expect_in(attempt(""), {"run.cih", "\"File Format\" is missing in this header"});
    expect_in(attempt(cih(1, 8, "Color Type : Bayer\n")), {"run.cih", "Color Type : Bayer", "\"mono\""});
    expect_in(attempt(cih(1, 8, "File Format : TIFF\n")), {"run.cih", "File Format : TIFF", "\"mraw\""});
    expect_in(attempt(cih(1, 9)), {"run.cih", "Color Bit : 9", "8, 10, 12 or 16"});
    expect_in(attempt(cih(1, 8, "Image Width : -3\n")), {"run.cih", "Image Width : -3", "1 to 65536"});
    expect_in(attempt(cih(1, 8, "Image Height : many\n")), {"run.cih", "Image Height : many"});
    expect_in(attempt(cih(1, 8, "Total Frame : 0\n")), {"run.cih", "Total Frame : 0"});
    expect_in(attempt(cih(1, 8, "Record Rate(fps) : 0\n")), {"run.cih", "Record Rate(fps) : 0"});
    expect_in(attempt(cih(1, 8, "Image Width : 65536\nImage Height : 65536\n")), {"run.mraw: is cut short"});
    expect_in(attempt(cih(1, 12, "Image Width : 3\nImage Height : 3\n")),
              {"run.cih", "not a whole number of bytes"});
    std::filesystem::remove(folder / "run.mraw");
    expect_in(attempt(cih(1, 8)), {"run.mraw", "No such file", "same folder as run.cih"});
}

struct Cine {
    int frames = 3;
    unsigned bits = 16;
    int stored_width = width;
    int stored_height = height;  // negative: top row first
    std::uint32_t file_compression = 0;
    std::uint32_t bitmap_compression = 0;
    std::uint32_t notes_bytes = 24;
    std::uint32_t frames_promised = 3;
    std::uint32_t offsets_moved = 0;

    [[nodiscard]] std::string bytes() const {
        constexpr std::size_t setup_bytes = 900;
        const int rows = std::abs(stored_height), bytes_per_pixel = static_cast<int>(bits / 8);
        const std::size_t row = (static_cast<std::size_t>(stored_width * bytes_per_pixel) + 3) / 4 * 4;
        const bool packed = bits == 10 || bits == 12;
        const std::size_t image =
            packed ? packed_picture(0, bits).size() : row * static_cast<std::size_t>(rows);
        const std::size_t offsets_at = 44 + 40 + setup_bytes;
        std::string text = "CI" + little_endian(44, 2) + little_endian(file_compression, 2) +
                           little_endian(1, 2) + little_endian(0, 4) + little_endian(frames_promised, 4) +
                           little_endian(0, 4) + little_endian(frames_promised, 4) + little_endian(44, 4) +
                           little_endian(84, 4) + little_endian(offsets_at + offsets_moved, 4) +
                           little_endian(0, 8);
        text += little_endian(40, 4) + little_endian(static_cast<std::uint32_t>(stored_width), 4) +
                little_endian(static_cast<std::uint32_t>(stored_height), 4) + little_endian(1, 2) +
                little_endian(packed ? 16 : bits, 2) + little_endian(bitmap_compression, 4) +
                little_endian(image, 4) + std::string(16, '\0');
        std::string setup(setup_bytes, '\0');
        setup.replace(140, 2, "ST");
        setup.replace(768, 4, little_endian(2500, 4));
        text += setup;
        const std::size_t pictures_at = offsets_at + 8 * static_cast<std::size_t>(frames);
        for (int k = 0; k < frames; ++k)
            text += little_endian(pictures_at + static_cast<std::size_t>(k) * (notes_bytes + image), 8);
        for (int k = 0; k < frames; ++k) {
            text +=
                little_endian(notes_bytes, 4) + std::string(notes_bytes - 8, 'n') + little_endian(image, 4);
            if (packed) text += packed_picture(k, bits);
            for (int stored = 0; stored < rows && !packed; ++stored) {
                const int y = stored_height > 0 ? rows - 1 - stored : stored;
                std::string line;
                for (int x = 0; x < stored_width; ++x)
                    line += little_endian(grey(k, x, y, bits), bytes_per_pixel);
                line.resize(row, '\0');
                text += line;
            }
        }
        return text;
    }
};

TEST(PhantomTest, ReadsAllBitsForEitherRowOrder) {
    for (const unsigned bits : {8U, 16U})
        for (const int stored_height : {height, -height}) {
            const SessionFolder folder;
            const Cine cine{.bits = bits, .stored_height = stored_height};
            const auto media = open(folder.write("run.cine", cine.bytes()));
            EXPECT_EQ(media->rate_hz(), 2500.0);
            EXPECT_EQ(media->count(), 3);
            expect_pictures(*media, {0, 1, 2}, bits);
        }
}

TEST(PhantomTest, PackedPicturesAreReadWithAllBitsTopRowFirst) {
    for (const auto& [bits, compression] : {std::pair{10U, 256U}, {12U, 1024U}}) {
        const SessionFolder folder;
        const Cine cine{.bits = bits, .bitmap_compression = compression};
        expect_pictures(*open(folder.write("run.cine", cine.bytes())), {0, 1, 2}, bits);
    }
}

TEST(PhantomTest, RowsPaddedToFourBytesAreReadWithoutThePadding) {
    const SessionFolder folder;
    const Cine cine{.bits = 8, .stored_width = 5};
    const auto media = open(folder.write("run.cine", cine.bytes()));
    Picture picture;
    ASSERT_TRUE(media->next(picture));
    ASSERT_EQ(picture.pixels.size(), 5U * height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < 5; ++x) EXPECT_EQ(value_at(picture, media->format(), x, y), grey(0, x, y, 8));
}

TEST(PhantomTest, RefusesTruncatedFileWithoutReadingPastEnd) {
    const SessionFolder folder;
    const std::string whole = Cine{}.bytes();
    for (std::size_t size = 0; size < whole.size(); size += 29) {
        const std::string message = refusal([&] {
            const auto media = open(folder.write("run.cine", whole.substr(0, size)));
            all_pictures(*media);
        });
        expect_in(message, {"run.cine"});
        EXPECT_NE(message, "accepted") << size;
    }
}

TEST(PhantomTest, RefusesCompressedOrColourPictures) {
    const SessionFolder folder;
    const auto attempt = [&](const Cine& cine) {
        return refusal([&] {
            const auto media = open(folder.write("run.cine", cine.bytes()));
            all_pictures(*media);
        });
    };
    expect_in(attempt({.file_compression = 2}), {"run.cine", "colour", "compression 2"});
    expect_in(attempt({.file_compression = 1}), {"run.cine", "compressed", "compression 1"});
    expect_in(attempt({.bitmap_compression = 7}), {"run.cine", "compressed", "bitmap compression 7"});
    expect_in(attempt({.bitmap_compression = 256}),
              {"run.cine", "144 bytes do not fit 12 x 6 pixels of 10 bits"});
    expect_in(attempt({.bits = 24}), {"run.cine", "24 bits per pixel"});
    expect_in(attempt({.stored_width = 0}), {"run.cine", "0 x 6 pixels"});
    expect_in(attempt({.stored_height = 0}), {"run.cine", "12 x 0 pixels"});
    expect_in(attempt({.frames_promised = 0}), {"run.cine", "no pictures"});
    expect_in(attempt({.frames_promised = 4000000000U}),
              {"run.cine", "cut short", "4000000000 picture offsets"});
    expect_in(attempt({.offsets_moved = 4000000000U}), {"run.cine", "cut short"});
    expect_in(attempt({.offsets_moved = 4}), {"run.cine", "picture 0"});
    expect_in(refusal([&] { open(folder.write("run.cine", "RIFF....")); }), {"run.cine", "not a Phantom"});
}

std::filesystem::path write_movie(const SessionFolder& folder, int frames, bool colour,
                                  const std::string& codec = "FFV1") {
    auto file = folder / "run.avi";
    cv::VideoWriter writer{
        file.string(), cv::CAP_FFMPEG, cv::VideoWriter::fourcc(codec[0], codec[1], codec[2], codec[3]),
        25.0,          {64, 48},       true};
    for (int k = 0; k < frames; ++k) {
        cv::Mat image(48, 64, CV_8UC3);
        for (int y = 0; y < 48; ++y)
            for (int x = 0; x < 64; ++x) {
                const auto value = static_cast<std::uint8_t>(20 + 4 * ((x / 16 + y / 16 + k) % 40));
                image.at<cv::Vec3b>(y, x) = {value, value,
                                             static_cast<std::uint8_t>(colour ? 255 - value : value)};
            }
        writer.write(image);
    }
    return file;
}

TEST(MovieTest, ReturnsEveryPictureOnce) {
    for (const bool colour : {false, true}) {
        const SessionFolder folder;
        const auto media = open(write_movie(folder, 10, colour));
        EXPECT_EQ(media->format(), (PictureFormat{64, 48, 1}));
        EXPECT_EQ(media->rate_hz(), 25.0);
        const auto pictures = all_pictures(*media);
        ASSERT_EQ(pictures.size(), 10U);
        for (int k = 0; k < 10; ++k) {
            EXPECT_EQ(pictures[static_cast<std::size_t>(k)].number, k);
            if (colour) continue;
            // The writer goes through YUV, which may round by one grey value.
            EXPECT_NEAR(value_at(pictures[static_cast<std::size_t>(k)], media->format(), 8, 8),
                        20 + 4 * (k % 40), 2);
        }
    }
}

/// Overwrites picture number `which` in an AVI, whose chunks of pictures are marked "00dc" and their size.
void destroy_picture(const std::filesystem::path& file, int which) {
    std::ifstream in{file, std::ios::binary};
    std::string bytes{std::istreambuf_iterator<char>{in}, {}};
    std::size_t at = bytes.find("movi");
    for (int k = 0; k <= which; ++k) at = bytes.find("00dc", at + 4);
    std::uint32_t size = 0;
    std::memcpy(&size, &bytes.at(at + 4), sizeof size);
    bytes.replace(at + 8, size, size, '\0');
    std::ofstream{file, std::ios::binary} << bytes;
}

TEST(MovieTest, CountsUndecodablePictureAsMissing) {
    const SessionFolder folder;
    const auto file = write_movie(folder, 10, false, "MJPG");
    destroy_picture(file, 4);
    const auto media = open(file);
    const auto pictures = all_pictures(*media);
    ASSERT_EQ(pictures.size(), 9U);
    for (std::size_t k = 0; k < pictures.size(); ++k) {
        EXPECT_EQ(pictures[k].number, static_cast<std::int64_t>(k < 4 ? k : k + 1)) << k;
        const int number = static_cast<int>(k < 4 ? k : k + 1);
        EXPECT_NEAR(value_at(pictures[k], media->format(), 8, 8), 20 + 4 * number, 3);  // what JPEG may lose
    }
}

TEST(MovieTest, RefusesFileThatIsNotMovie) {
    const SessionFolder folder;
    expect_in(refusal([&] { open(folder.write("run.mkv", "this is not a movie")); }),
              {"run.mkv", "not a movie"});
    expect_in(refusal([&] { open(folder.write("empty.avi", "")); }), {"empty.avi"});
}

}  // namespace
}  // namespace shaker::footage
