// Control plug-in that libasound loads into its client: the client's side of a mock mixer.
//
//   ctl_type.shaker_mock_mixer { lib "/.../shaker_mock_pcm.so" }
//   ctl.card { type shaker_mock_mixer  file "/dev/shm/mixer" }
#include <alsa/asoundlib.h>
#include <alsa/control_external.h>
#include <fcntl.h>
#include <sys/mman.h>

#include <cstring>
#include <memory>

#include "drivers/descriptor.hpp"
#include "tests/mock/sound/mixer_memory.hpp"

namespace {

using shaker::mock::MixerMemory;

struct Card {
    snd_ctl_ext_t ext{};
    MixerMemory* memory = nullptr;
    ~Card() {
        if (memory != nullptr) ::munmap(memory, sizeof(MixerMemory));
    }
};

MixerMemory& memory_of(snd_ctl_ext_t* ext) { return *static_cast<Card*>(ext->private_data)->memory; }

void close(snd_ctl_ext_t* ext) { delete static_cast<Card*>(ext->private_data); }

int elem_count(snd_ctl_ext_t* /*ext*/) { return static_cast<int>(MixerMemory::controls.size()); }

int elem_list(snd_ctl_ext_t* /*ext*/, unsigned offset, snd_ctl_elem_id_t* id) {
    if (offset >= MixerMemory::controls.size()) return -EINVAL;
    snd_ctl_elem_id_set_interface(id, SND_CTL_ELEM_IFACE_MIXER);
    snd_ctl_elem_id_set_name(id, MixerMemory::controls.at(offset).name);
    return 0;
}

snd_ctl_ext_key_t find_elem(snd_ctl_ext_t* /*ext*/, const snd_ctl_elem_id_t* id) {
    for (std::size_t i = 0; i < MixerMemory::controls.size(); ++i)
        if (std::strcmp(snd_ctl_elem_id_get_name(id), MixerMemory::controls.at(i).name) == 0) return i;
    return SND_CTL_EXT_KEY_NOT_FOUND;
}

int get_attribute(snd_ctl_ext_t* /*ext*/, snd_ctl_ext_key_t key, int* type, unsigned* access,
                  unsigned* count) {
    const MixerMemory::Control& control = MixerMemory::controls.at(key);
    *type = control.is_switch ? SND_CTL_ELEM_TYPE_BOOLEAN : SND_CTL_ELEM_TYPE_INTEGER;
    *access = control.by_itself ? SND_CTL_EXT_ACCESS_READ | SND_CTL_EXT_ACCESS_VOLATILE
                                : SND_CTL_EXT_ACCESS_READWRITE;
    *count = control.values;
    return 0;
}

int get_integer_info(snd_ctl_ext_t* /*ext*/, snd_ctl_ext_key_t key, long* least, long* most, long* step) {
    *least = 0;
    *most = MixerMemory::controls.at(key).is_switch ? 1 : 255;
    *step = 1;
    return 0;
}

int read_integer(snd_ctl_ext_t* ext, snd_ctl_ext_key_t key, long* values) {
    MixerMemory& m = memory_of(ext);
    ++m.reads;
    if (MixerMemory::controls.at(key).by_itself) m.values.at(key)[0] = static_cast<long>(m.reads % 256);
    for (unsigned k = 0; k < MixerMemory::controls.at(key).values; ++k) values[k] = m.values.at(key).at(k);
    return 0;
}

int write_integer(snd_ctl_ext_t* ext, snd_ctl_ext_key_t key, long* values) {
    for (unsigned k = 0; k < MixerMemory::controls.at(key).values; ++k)
        memory_of(ext).values.at(key).at(k) = values[k];
    return 1;
}

void subscribe_events(snd_ctl_ext_t* /*ext*/, int /*subscribe*/) {}
int read_event(snd_ctl_ext_t* /*ext*/, snd_ctl_elem_id_t* /*id*/, unsigned* /*mask*/) { return -EAGAIN; }

const snd_ctl_ext_callback_t mixer_callbacks = [] {
    snd_ctl_ext_callback_t c{};
    c.close = close;
    c.elem_count = elem_count;
    c.elem_list = elem_list;
    c.find_elem = find_elem;
    c.get_attribute = get_attribute;
    c.get_integer_info = get_integer_info;
    c.read_integer = read_integer;
    c.write_integer = write_integer;
    c.subscribe_events = subscribe_events;
    c.read_event = read_event;
    return c;
}();

}  // namespace

extern "C" {

SND_CTL_PLUGIN_DEFINE_FUNC(shaker_mock_mixer) {
    static_cast<void>(root);
    snd_config_t* entry = nullptr;
    const char* file = nullptr;
    if (snd_config_search(conf, "file", &entry) < 0 || snd_config_get_string(entry, &file) < 0) {
        SNDERR("shaker_mock_mixer: `file` is missing");
        return -EINVAL;
    }
    const shaker::Descriptor fd{::open(file, O_RDWR | O_CLOEXEC)};
    if (fd < 0) return -errno;
    void* at = ::mmap(nullptr, sizeof(MixerMemory), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    if (at == MAP_FAILED) return -errno;
    auto card = std::make_unique<Card>();
    card->memory = static_cast<MixerMemory*>(at);
    if (card->memory->ready.load(std::memory_order_acquire) != MixerMemory::version) return -EINVAL;
    card->ext.version = SND_CTL_EXT_VERSION;
    card->ext.card_idx = 0;
    std::strcpy(card->ext.id, "Mock");
    std::strcpy(card->ext.driver, "Mock");
    std::strcpy(card->ext.name, "Mock");
    std::strcpy(card->ext.longname, "Mock");
    std::strcpy(card->ext.mixername, "Mock");
    card->ext.poll_fd = -1;
    card->ext.callback = &mixer_callbacks;
    card->ext.private_data = card.get();
    if (const int error = snd_ctl_ext_create(&card->ext, name, mode); error < 0) return error;
    *handlep = card.release()->ext.handle;
    return 0;
}

SND_CTL_PLUGIN_SYMBOL(shaker_mock_mixer)
}
