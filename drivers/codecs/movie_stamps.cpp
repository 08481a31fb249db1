// Part of the module shaker_codecs.so: what a movie's container states of its pictures. Only its index is
// read, no picture is decoded.
#include "drivers/codecs/movie_stamps.hpp"

#include <algorithm>
#include <memory>
#include <string>

extern "C" {
#include <libavformat/avformat.h>
}

namespace shaker::codecs {
namespace {

struct CloseMovie {
    void operator()(AVFormatContext* movie) const noexcept { avformat_close_input(&movie); }
};
struct FreePacket {
    void operator()(AVPacket* packet) const noexcept { av_packet_free(&packet); }
};

bool is_interlaced(const AVStream& video) {
    switch (video.codecpar->field_order) {
        case AV_FIELD_TT:
        case AV_FIELD_BB:
        case AV_FIELD_TB:
        case AV_FIELD_BT:
            return true;
        default:
            return false;
    }
}

/// Only these containers have a true number of pictures in their index; that of others is a guess from the
/// length of the movie, or missing.
bool counts_pictures(const AVInputFormat& format) {
    const std::string_view names{format.name};
    return names.find("mp4") != std::string_view::npos || names == "avi";
}

}  // namespace

MovieStamps movie_stamps(const std::string& file) {
    av_log_set_level(AV_LOG_QUIET);
    AVFormatContext* opened = nullptr;
    if (avformat_open_input(&opened, ("file:" + file).c_str(), nullptr, nullptr) < 0) return {};
    const std::unique_ptr<AVFormatContext, CloseMovie> movie{opened};
    opened->flags |= AVFMT_FLAG_GENPTS;  // MPEG streams state some of them only
    if (avformat_find_stream_info(opened, nullptr) < 0) return {};
    const int number = av_find_best_stream(opened, AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
    if (number < 0) return {};
    const AVStream& video = *opened->streams[number];
    MovieStamps stamps;
    stamps.interlaced = is_interlaced(video);
    if ((opened->iformat->flags & AVFMT_NOTIMESTAMPS) != 0) return stamps;
    const double unit_s = av_q2d(video.time_base);
    stamps.resolution_s = unit_s;
    const double rate_hz = av_q2d(video.r_frame_rate);
    if (rate_hz > 0 && rate_hz < most_movie_hz) stamps.rate_hz = rate_hz;
    stamps.alone = opened->nb_streams == 1;
    const double start_s =
        video.start_time == AV_NOPTS_VALUE ? 0 : static_cast<double>(video.start_time) * unit_s;
    // Some programs count the length from the first picture, others from 0: the shorter one is certain.
    if (opened->duration != AV_NOPTS_VALUE)
        stamps.states_s = static_cast<double>(opened->duration) / AV_TIME_BASE - std::max(start_s, 0.0);
    std::int64_t hidden = 0;
    const std::unique_ptr<AVPacket, FreePacket> packet{av_packet_alloc()};
    for (; av_read_frame(opened, packet.get()) >= 0; av_packet_unref(packet.get())) {
        if (packet->stream_index != number) continue;
        if ((packet->flags & AV_PKT_FLAG_DISCARD) != 0) {  // an edit list hides it
            ++hidden;
            continue;
        }
        if (packet->pts == AV_NOPTS_VALUE) {
            stamps.at_s.clear();
            stamps.rate_hz.reset();  // a guess
            return stamps;
        }
        stamps.at_s.push_back(static_cast<double>(packet->pts) * unit_s);
    }
    std::sort(stamps.at_s.begin(), stamps.at_s.end());
    for (double& at_s : stamps.at_s) at_s -= start_s;
    if (counts_pictures(*opened->iformat) && video.nb_frames > 0) stamps.promised = video.nb_frames - hidden;
    return stamps;
}

}  // namespace shaker::codecs
