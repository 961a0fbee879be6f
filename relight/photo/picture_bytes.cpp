// SPDX-License-Identifier: Apache-2.0
#include "relight/photo/picture_bytes.h"

#include "relight/base/error.h"
#include "relight/base/write_file.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <sys/mman.h>
#include <unistd.h>

#include <limits>
#include <memory>

namespace relight {
namespace {

// A file in memory that has a path. OpenImageIO's own memory files cannot be read back
// while they are written, which TIFF needs for its directories.
class MemoryFile {
 public:
  MemoryFile() : descriptor_(memfd_create("picture", MFD_CLOEXEC)) {
    Require(descriptor_ >= 0, "a file in memory");
  }
  ~MemoryFile() { close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
};

struct Writer {
  const char* name;
  const char* extension;  // The writer of OpenImageIO wants to see one.
};

Writer WriterOf(PictureFormat format) {
  switch (format) {
    case PictureFormat::kJpeg:
      return {"jpeg", ".jpg"};
    case PictureFormat::kPng:
      return {"png", ".png"};
    case PictureFormat::kTiff:
      return {"tiff", ".tif"};
    case PictureFormat::kExr:
      return {"openexr", ".exr"};
    default:
      Require(false, "only JPEG, PNG, TIFF and EXR are written");
      return {"", ""};
  }
}

OIIO::TypeDesc TypeInMemory(const cv::Mat& samples) {
  switch (samples.depth()) {
    case CV_8U:
      return OIIO::TypeDesc::UINT8;
    case CV_16U:
      return OIIO::TypeDesc::UINT16;
    default:
      Require(samples.depth() == CV_32F, "samples are of 8 or 16 bits, or floats");
      return OIIO::TypeDesc::FLOAT;
  }
}

}  // namespace

std::string EncodePicture(PictureFormat format,
                          const PictureToEncode& picture,
                          const std::filesystem::path& file) {
  const cv::Mat& samples = picture.samples;
  Require(static_cast<int>(picture.channels.size()) == samples.channels(),
          "a name for each channel");
  Require(!samples.empty() && samples.isContinuous(), "a picture in one piece of memory");
  const Writer writer = WriterOf(format);
  const OIIO::TypeDesc in_memory = TypeInMemory(samples);
  OIIO::ImageSpec spec(samples.cols,
                       samples.rows,
                       samples.channels(),
                       picture.half ? OIIO::TypeDesc(OIIO::TypeDesc::HALF) : in_memory);
  spec.channelnames = picture.channels;
  spec.alpha_channel = picture.alpha_channel;
  spec.attribute("oiio:UnassociatedAlpha", 1);
  spec.attribute("oiio:ColorSpace", picture.display_encoded ? "sRGB" : "Linear");
  // Without one, OpenImageIO writes the time of now: the same picture, other bytes
  spec.attribute("DateTime", "");
  if (format == PictureFormat::kJpeg) {
    spec.attribute("compression", "jpeg:" + std::to_string(picture.quality));
    // Leaves are finer than pairs of pixels, and so are their colours
    spec.attribute("jpeg:subsampling", picture.quality >= 90 ? "4:4:4" : "4:2:0");
  } else if (format == PictureFormat::kPng) {
    spec.attribute("png:compressionLevel", 4);  // 6 takes twice as long for 2 % less
  } else {
    spec.attribute("compression", "zip");
  }
  for (const auto& [name, value] : picture.metadata) spec.attribute(name, value);

  const std::unique_ptr<OIIO::ImageOutput> output =
      OIIO::ImageOutput::create(writer.name);
  if (!output) {
    throw InputError(file.string() + ": this OpenImageIO cannot write " + writer.name +
                     "; choose another extension");
  }
  const auto make = [&](const std::string& name) {
    if (!output->open(name, spec) || !output->write_image(in_memory, samples.data) ||
        !output->close() || output->has_error()) {
      throw InputError(file.string() + ": cannot be made: " + output->geterror() +
                       "; free some space, or choose another format by its extension");
    }
  };
  if (format == PictureFormat::kTiff) {
    const MemoryFile memory;
    make(memory.path());
    return ReadText(memory.path(), std::numeric_limits<std::size_t>::max());
  }
  std::vector<unsigned char> bytes;
  OIIO::Filesystem::IOVecOutput memory(bytes);
  void* proxy = &memory;
  spec.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
  make(std::string("picture") + writer.extension);
  return {bytes.begin(), bytes.end()};
}

}  // namespace relight
