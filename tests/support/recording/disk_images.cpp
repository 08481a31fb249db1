#include "tests/support/recording/disk_images.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace shaker::test {

namespace {

constexpr std::int64_t page = 4096;  // bytes that reach a disk together

// A file that is being rebuilt.
class Image {
public:
    explicit Image(const std::filesystem::path& file)
        : descriptor_{::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600)} {
        if (descriptor_ < 0) throw std::runtime_error{file.string() + ": cannot be made"};
    }
    Image(const Image&) = delete;
    Image& operator=(const Image&) = delete;
    ~Image() { ::close(descriptor_); }
    void write(std::int64_t at, std::span<const std::byte> bytes) {
        if (::pwrite(descriptor_, bytes.data(), bytes.size(), at) != static_cast<ssize_t>(bytes.size()))
            throw std::runtime_error{"an image cannot be written"};
    }
    void resize(std::int64_t bytes) {
        if (::ftruncate(descriptor_, bytes) != 0) throw std::runtime_error{"an image cannot be cut"};
    }

private:
    int descriptor_;
};

bool names_something(DiskCall call) { return call <= DiskCall::remove; }

std::int64_t length_after(const DiskEntry& e, std::int64_t length) {
    if (e.call == DiskCall::size) return e.at;
    if (e.call == DiskCall::reserve) return std::max(length, e.at);
    if (e.call == DiskCall::write) return std::max(length, e.at + static_cast<std::int64_t>(e.bytes));
    return length;
}

struct Slice {
    std::int64_t at;
    std::span<const std::byte> bytes;
};

}  // namespace

const char* name(Surviving surviving) noexcept {
    switch (surviving) {
        case Surviving::all:
            return "all that was written";
        case Surviving::half:
            return "synced and half the pages since";
        case Surviving::synced:
            return "only what was synced";
    }
    return "";
}

DiskImages::DiskImages(const std::filesystem::path& log, std::filesystem::path folder)
    : folder_{std::move(folder)} {
    const std::size_t bytes = std::filesystem::file_size(log);
    const int descriptor = ::open(log.c_str(), O_RDONLY | O_CLOEXEC);
    void* const at = ::mmap(nullptr, bytes, PROT_READ, MAP_PRIVATE, descriptor, 0);
    ::close(descriptor);
    if (at == MAP_FAILED) throw std::runtime_error{log.string() + ": cannot be read"};
    mapped_ = {static_cast<const std::byte*>(at), bytes};
    read(mapped_);
}

DiskImages::~DiskImages() { ::munmap(const_cast<std::byte*>(mapped_.data()), mapped_.size()); }

void DiskImages::read(std::span<const std::byte> log) {
    const auto next = [&](std::size_t bytes) {
        if (bytes > log.size()) throw std::runtime_error{"the log ends within an entry"};
        const auto piece = log.first(bytes);
        log = log.subspan(bytes);
        return piece;
    };
    const auto text = [&](std::size_t bytes) {
        const auto piece = next(bytes);
        return std::string{reinterpret_cast<const char*>(piece.data()), piece.size()};
    };
    std::map<std::uint64_t, std::uint64_t> newest;  // of the files that had an inode: their number
    while (!log.empty()) {
        Call& call = calls_.emplace_back();
        DiskEntry& entry = call.entry;
        std::memcpy(&entry, next(sizeof entry).data(), sizeof entry);
        if (entry.call == DiskCall::create) newest[entry.file] = calls_.size();
        if (entry.file != 0) entry.file = newest[entry.file];
        call.name = text(call.entry.name_bytes);
        call.second = text(call.entry.second_bytes);
        call.bytes = next(call.entry.bytes);
    }
}

std::vector<std::size_t> DiskImages::syncs(const std::string& file_name) const {
    std::vector<std::size_t> cuts;
    for (std::size_t i = 0; i < calls_.size(); ++i)
        if (calls_[i].entry.call == DiskCall::sync &&
            std::filesystem::path{calls_[i].name}.filename() == file_name)
            cuts.push_back(i + 1);
    return cuts;
}

// Changes of names reach the disk in their order, folder by folder.
std::vector<std::size_t> DiskImages::names_kept(std::size_t cut, Surviving surviving,
                                                std::mt19937_64& random) const {
    std::map<std::string, std::uint64_t> covered;  // a folder's
    std::map<std::string, std::vector<std::size_t>> since;
    std::vector<std::size_t> kept;
    for (std::size_t i = 0; i < cut; ++i)
        if (calls_[i].entry.call == DiskCall::sync_folder)
            covered[calls_[i].name] = std::max(covered[calls_[i].name], calls_[i].entry.covered);
    for (std::size_t i = 0; i < cut; ++i) {
        if (!names_something(calls_[i].entry.call)) continue;
        const std::string parent = std::filesystem::path{calls_[i].name}.parent_path();
        if (surviving == Surviving::all || i < covered[parent])
            kept.push_back(i);
        else
            since[parent].push_back(i);
    }
    if (surviving == Surviving::half)
        for (const auto& [parent, changes] : since) {
            const std::size_t some = random() % (changes.size() + 1);
            kept.insert(kept.end(), changes.begin(), changes.begin() + static_cast<std::ptrdiff_t>(some));
        }
    std::ranges::sort(kept);
    return kept;
}

DiskImages::Names DiskImages::names_after(const std::vector<std::size_t>& kept) const {
    Names names;
    for (const std::size_t i : kept) {
        const Call& call = calls_[i];
        if (call.entry.call == DiskCall::remove) {
            names.erase(call.name);
        } else if (call.entry.call == DiskCall::rename) {
            if (const auto from = names.extract(call.name)) names[call.second] = from.mapped();
        } else {
            names[call.name] = call.entry.file;
        }
    }
    return names;
}

void DiskImages::build_file(const std::filesystem::path& file, std::uint64_t number, std::size_t cut,
                            Surviving surviving, std::mt19937_64& random) const {
    std::uint64_t synced = surviving == Surviving::all ? cut : 0;
    std::vector<std::size_t> mine;
    for (std::size_t i = 0; i < cut; ++i) {
        if (calls_[i].entry.file != number) continue;
        mine.push_back(i);
        if (calls_[i].entry.call == DiskCall::sync) synced = std::max(synced, calls_[i].entry.covered);
    }
    Image image{file};
    std::int64_t length = 0;
    std::map<std::int64_t, std::vector<Slice>> pages;                 // written since the last sync
    const std::size_t told = synced + random() % (cut - synced + 1);  // the length is that of this moment
    for (const std::size_t i : mine) {
        const Call& call = calls_[i];
        if (i < synced || (surviving == Surviving::half && i < told)) {
            const std::int64_t next = length_after(call.entry, length);
            if (next < length) image.resize(next);
            length = next;
        }
        if (call.entry.call != DiskCall::write) continue;
        if (i < synced) {
            image.write(call.entry.at, call.bytes);
            continue;
        }
        for (std::int64_t at = call.entry.at, end = at + static_cast<std::int64_t>(call.bytes.size());
             at < end;) {
            const std::int64_t next = std::min(end, (at / page + 1) * page);
            pages[at / page].push_back({at, call.bytes.subspan(static_cast<std::size_t>(at - call.entry.at),
                                                               static_cast<std::size_t>(next - at))});
            at = next;
        }
    }
    if (surviving == Surviving::half)
        for (const auto& [at, slices] : pages) {
            if (random() % 2 == 0) continue;
            const std::size_t some = 1 + random() % slices.size();
            for (std::size_t k = 0; k < some; ++k) {
                image.write(slices[k].at, slices[k].bytes);
                length = std::max(length, slices[k].at + static_cast<std::int64_t>(slices[k].bytes.size()));
            }
        }
    image.resize(length);
}

void DiskImages::build(const std::filesystem::path& into, std::size_t cut, Surviving surviving,
                       std::uint64_t seed) const {
    std::mt19937_64 random{seed};
    for (const auto& [path, number] : names_after(names_kept(cut, surviving, random))) {
        const std::filesystem::path there = into / std::filesystem::path{path}.lexically_relative(folder_);
        if (number == 0)
            std::filesystem::create_directories(there);
        else if (std::filesystem::exists(there.parent_path()))
            build_file(there, number, cut, surviving, random);
    }
}

}  // namespace shaker::test
