#include "daemon/remote/web/live_frames.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>

#include "daemon/remote/access/access.hpp"
#include "daemon/remote/web/picture_figures.hpp"
#include "daemon/remote/web/subscription.hpp"

namespace shaker::web {
namespace {

template <class T>
T at(const std::string& bytes, std::size_t offset) {
    T value;
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
}

TEST(LiveFramesTest, HeaderHasTheLayoutOfThePage) {
    const std::string f = frame_of({.id = web::StreamId::track,
                                    .first = 7,
                                    .t0_s = 1.5,
                                    .dt_s = 0.25,
                                    .channels = {{1, 2, 3}, {4, 5, 6}},
                                    .gap = true,
                                    .pairs = false,
                                    .decimated = true});
    ASSERT_EQ(f.size(), 40U + 6 * 4);
    EXPECT_EQ(at<std::uint32_t>(f, 0), frame_magic);
    EXPECT_EQ(at<std::uint16_t>(f, 4), 1);
    EXPECT_EQ(at<std::uint16_t>(f, 6), 4);
    EXPECT_EQ(at<std::uint64_t>(f, 8), 7U);
    EXPECT_EQ(at<double>(f, 16), 1.5);
    EXPECT_EQ(at<double>(f, 24), 0.25);
    EXPECT_EQ(at<std::uint32_t>(f, 32), 3U);
    EXPECT_EQ(at<std::uint16_t>(f, 36), 2);
    EXPECT_EQ(at<std::uint16_t>(f, 38), 1 | 4);
    EXPECT_EQ(at<float>(f, 40), 1);
    EXPECT_EQ(at<float>(f, 44), 4) << "the values of a channel are contiguous";
}

TEST(LiveFramesTest, NoPeakIsHiddenByDecimation) {
    service::LiveSeries series{2, 10000};
    for (int i = 0; i < 5000; ++i)
        series.add(1e-3 * i, std::array{i == 1234 ? 9.0F : 0.0F, i == 4321 ? -7.0F : 0.0F});
    const web::Samples s = decimated(series.since(0), 2, 100, web::StreamId::acceleration);
    EXPECT_TRUE(s.pairs);
    EXPECT_LE(s.channels[0].size(), 200U);
    EXPECT_EQ(s.channels[0].size(), s.channels[1].size());
    EXPECT_EQ(std::ranges::max(s.channels[0]), 9);
    EXPECT_EQ(std::ranges::min(s.channels[1]), -7);
    EXPECT_NEAR(s.dt_s * static_cast<double>(s.channels[0].size()), 5, 0.06);
}

TEST(LiveFramesTest, DroppedUnreadSamplesAreAGap) {
    service::LiveSeries series{1, 10};
    for (int i = 0; i < 25; ++i) series.add(i, std::array{static_cast<float>(i)});
    const service::LiveSeries::Part part = series.since(3);
    EXPECT_TRUE(part.gap);
    EXPECT_EQ(part.first, 15U);
    EXPECT_EQ(part.values.front(), 15);
    EXPECT_FALSE(series.since(20).gap);
    EXPECT_TRUE(series.since(25).t_s.empty());
}

TEST(AccessTest, NamesOriginsAndTokens) {
    const access::Access a{.hosts = {"localhost", "[::1]"}, .token = "secret"};
    EXPECT_TRUE(a.host_allowed("LOCALHOST:8080"));
    EXPECT_TRUE(a.host_allowed("[::1]:8080"));
    EXPECT_FALSE(a.host_allowed("localhost.evil.example"));
    EXPECT_FALSE(a.host_allowed(""));
    EXPECT_TRUE(a.origin_allowed("", "localhost:1"));
    EXPECT_TRUE(a.origin_allowed("http://localhost:1", "localhost:1"));
    EXPECT_FALSE(a.origin_allowed("http://localhost:2", "localhost:1"));
    EXPECT_FALSE(a.origin_allowed("null", "localhost:1"));
    EXPECT_TRUE(a.token_allowed("secret"));
    for (const char* wrong : {"", "secre", "secrets", "Secret"})
        EXPECT_FALSE(a.token_allowed(wrong)) << wrong;
}

TEST(LiveSocketTest, SubscriptionsAreReadAndBounded) {
    const auto wish = wish_of(R"({"type":"subscribe","stream":"track","width":1e9,"rate_hz":-3})");
    ASSERT_TRUE(wish);
    EXPECT_EQ(wish->what.stream, "track");
    EXPECT_EQ(wish->what.width, 4096U);
    EXPECT_EQ(wish->what.rate_hz, 0.1);
    EXPECT_TRUE(wish_of(R"({"type":"unsubscribe","stream":"track"})")->end);
    for (const char* no : {"", "{", "[]", R"({"type":"subscribe"})", R"({"type":5,"stream":"a"})",
                           R"({"type":"dance","stream":"a"})"})
        EXPECT_FALSE(wish_of(no)) << no;
    EXPECT_FALSE(wish_of(R"({"type":"subscribe","stream":")" + std::string(100, 'x') + "\"}"));
}

// A vertical edge from 20 to 220 in the middle of the picture, blurred by a Gaussian of standard deviation sd
// px.
Frame edge_picture(double sd, int bright = 220) {
    Frame f;
    f.width = 200;
    f.height = 50;
    f.pixels.resize(200 * 50);
    for (int y = 0; y < f.height; ++y)
        for (int x = 0; x < f.width; ++x) {
            const double share =
                sd == 0 ? (x < 100 ? 0 : 1) : 0.5 * std::erfc((99.5 - x) / (sd * std::sqrt(2)));
            f.pixels[static_cast<std::size_t>(y * f.width + x)] =
                static_cast<std::byte>(std::lround(20 + (bright - 20) * share));
        }
    return f;
}

TEST(PictureFiguresTest, EdgeWidthGrowsWithBlur) {
    EXPECT_EQ(figures_of(edge_picture(0)).edge_px, 2);
    // A Gaussian edge: height over its steepest slope is sqrt(2 pi) sd. Values are whole numbers, and the
    // slope is that of 2 px: 7 %.
    for (const double sd : {2.0, 5.0}) {
        const double width_px = std::sqrt(2 * std::numbers::pi) * sd;
        EXPECT_NEAR(figures_of(edge_picture(sd)).edge_px, width_px, 0.07 * width_px);
    }
    EXPECT_TRUE(std::isnan(figures_of(edge_picture(0, 20)).edge_px)) << "a picture without an edge";
    EXPECT_TRUE(std::isnan(figures_of(Frame{}).edge_px));
}

TEST(PictureFiguresTest, ClippedPixelsAreAShare) {
    EXPECT_EQ(figures_of(edge_picture(0)).clipped, 0);
    EXPECT_EQ(figures_of(edge_picture(0, 255)).clipped, 0.5);
}

}  // namespace
}  // namespace shaker::web
