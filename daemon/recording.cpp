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
    writer_->scalar("process/reduced_from", from_s, "s");
    writer_->scalar("process/reduced_to", to_s, "s");
    write(*writer_, tables_of(take));
    write(*writer_, tables_of(reduction));
    write(*writer_, numbers_of(reduction));
    complete();
}

void Recording::finish(const Take& take) {
    if (!writer_) return;
    write(*writer_, tables_of(take));
    write_trips(*writer_, take);
    complete();
}

void Recording::complete() {
    writer_->flush();
    writer_.reset();
    std::filesystem::rename(part_, file_);
}

}  // namespace shaker
