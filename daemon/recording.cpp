#include "daemon/recording.hpp"

namespace shaker {

Recording::Recording(const std::filesystem::path& file, const SessionHeader& header, Unfinished unfinished)
    : file_{file}, unfinished_{unfinished} {
    if (file.empty()) return;
    part_ = file;
    part_ += ".part";
    writer_ = std::make_unique<SessionWriter>(part_, header);
}

Recording::~Recording() {
    if (!writer_) return;
    writer_.reset();
    std::error_code ignored;
    if (unfinished_ == Unfinished::discard) std::filesystem::remove(part_, ignored);
}

void Recording::finish(const Take& take, const Reduction& reduction, double from_s, double to_s) {
    if (!writer_) return;
    write(*writer_, reduction, from_s, to_s);
    finish(take);
}

void Recording::finish(const Take& take) {
    if (!writer_) return;
    write(*writer_, tables_of(take));
    writer_->flush();
    writer_.reset();
    std::filesystem::rename(part_, file_);
}

}  // namespace shaker
