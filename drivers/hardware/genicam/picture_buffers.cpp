#include "drivers/hardware/genicam/picture_buffers.hpp"

#include <arv.h>

#include <algorithm>
#include <functional>

namespace shaker::genicam {

PictureBuffers::PictureBuffers(const GenicamPicture& picture, std::size_t queued, std::size_t given)
    : format_{picture.format},
      direct_{picture.format->packing == Packing::none && !picture.chunks},
      depth_{queued},
      pool_{static_cast<int>(direct_ ? queued + given : given), picture.width, picture.height,
            picture.format->bytes_per_pixel()},
      slots_(direct_ ? queued + given : queued) {
    for (Slot& slot : slots_) {
        if (direct_)
            slot.frame = pool_.acquire();
        else
            slot.wire.resize(picture.payload_bytes);
        slot.memory = slot.frame.get();
    }
    std::ranges::sort(slots_, std::less<>{}, &Slot::memory);
    for (Slot& slot : slots_) {
        std::vector<std::byte>& memory = direct_ ? slot.frame->pixels : slot.wire;
        slot.buffer = arv_buffer_new_full(memory.size(), memory.data(), &slot, nullptr);
        slot.frame.reset();
    }
}

PictureBuffers::~PictureBuffers() {
    for (const Slot& slot : slots_) g_object_unref(slot.buffer);
}

PictureBuffers::Slot& PictureBuffers::slot_of(ArvBuffer* buffer) noexcept {
    return *static_cast<Slot*>(const_cast<void*>(arv_buffer_get_user_data(buffer)));
}

void PictureBuffers::push(Slot& slot, ArvStream* stream) {
    slot.queued = true;
    ++queued_;
    arv_stream_push_buffer(stream, ARV_BUFFER(g_object_ref(slot.buffer)));
}

void PictureBuffers::queue(ArvStream* stream) {
    if (!direct_) {
        if (queued_ == slots_.size()) return;
        for (Slot& slot : slots_)
            if (!slot.queued) push(slot, stream);
        return;
    }
    while (queued_ < depth_) {
        std::shared_ptr<Frame> frame = pool_.acquire();
        if (frame == nullptr) return;
        const auto slot = std::ranges::lower_bound(slots_, frame.get(), std::less<>{}, &Slot::memory);
        slot->frame = std::move(frame);
        push(*slot, stream);
    }
}

std::shared_ptr<Frame> PictureBuffers::take(ArvBuffer* buffer) {
    Slot& slot = slot_of(buffer);
    std::shared_ptr<Frame> frame = direct_ ? std::move(slot.frame) : pool_.acquire();
    if (frame != nullptr && !direct_) unpack_pixels(*format_, slot.wire, frame->pixels);
    discard(buffer);
    return frame;
}

void PictureBuffers::discard(ArvBuffer* buffer) noexcept {
    Slot& slot = slot_of(buffer);
    slot.frame.reset();
    slot.queued = false;
    --queued_;
    g_object_unref(buffer);
}

void PictureBuffers::reclaim() noexcept {
    for (Slot& slot : slots_) {
        slot.frame.reset();
        slot.queued = false;
    }
    queued_ = 0;
}

}  // namespace shaker::genicam
