#include "drivers/recorded/pictures/picture_link.hpp"

#include <algorithm>

#include "drivers/recorded/h5/image.hpp"
#include "drivers/recorded/pictures/segment_types.hpp"

namespace shaker::pictures {

namespace {

/// Selects `count` rows of a data set from `first` on.
h5::Handle rows(const std::vector<hsize_t>& shape, hsize_t first, hsize_t count) {
    h5::Handle space{H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), "rows"};
    std::vector<hsize_t> start(shape.size(), 0), extent = shape;
    start[0] = first;
    extent[0] = count;
    h5::check(H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, extent.data(), nullptr),
              "rows");
    return space;
}

/// shape: of the whole data set; its first axis covers the places of all segments.
h5::Handle joined(hid_t parent, const std::string& name, hid_t type, std::vector<hsize_t> shape,
                  const FoundSegments& segments) {
    const h5::Handle create{H5Pcreate(H5P_DATASET_CREATE), name};
    h5::check(H5Pset_obj_track_times(create.get(), false), name);
    const hsize_t last = shape[0];
    for (const FoundSegment& s : segments.good) {
        const hsize_t before = s.info.first - 1;
        if (before >= last) break;
        const hsize_t count = std::min<hsize_t>(s.info.places, last - before);
        if (count == 0) continue;
        std::vector<hsize_t> source = shape;
        source[0] = s.info.places;
        h5::check(H5Pset_virtual(create.get(), rows(shape, before, count).get(), s.file.filename().c_str(),
                                 ("/" + name).c_str(), rows(source, 0, count).get()),
                  name);
    }
    const h5::Handle space{H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), name};
    return {H5Dcreate2(parent, name.c_str(), type, space.get(), H5P_DEFAULT, create.get(), H5P_DEFAULT),
            name};
}

}  // namespace

void link_pictures(const std::filesystem::path& folder, const FoundSegments& segments, std::uint64_t last) {
    const PictureSegmentInfo& first = segments.good.front().info;
    const h5::Image file;
    h5::set_attribute(h5::open_group(file.id(), "/").get(), "camera", first.camera);
    const h5::Handle frames = joined(
        file.id(), "frames", pixel_type(first.shape),
        {last, static_cast<hsize_t>(first.shape.height), static_cast<hsize_t>(first.shape.width)}, segments);
    h5::set_attribute(frames.get(), "units", std::string{"count"});
    joined(file.id(), "index", record_type().get(), {last}, segments);
    h5::replace_file(link_file(folder, first.camera), file.head(file.size()));
}

}  // namespace shaker::pictures
