// SPDX-License-Identifier: Apache-2.0
#include "relight/photo/picture_file.h"

#include "relight/base/error.h"
#include "relight/base/write_file.h"
#include "relight/photo/heif_metadata.h"

#include <OpenImageIO/imageio.h>
#include <OpenImageIO/tiffutils.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <new>
#include <string_view>
#include <system_error>

namespace relight {
namespace fs = std::filesystem;

struct PictureFile::Input {
  std::unique_ptr<OIIO::ImageInput> reader;
  OIIO::ImageSpec spec;
};

namespace {

constexpr char kFormats[] = "relight reads JPEG, PNG, TIFF, HEIC, RAW and OpenEXR";
constexpr double kMaxPixels = 1e9;
constexpr int kBandRows = 256;  // A row of DWA blocks of an EXR; 24 MB of a 24 MP photo.

std::string Lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return text;
}

bool HasRawExtension(const fs::path& path) {
  static constexpr std::array kRaw = {
      ".dng", ".nef", ".nrw", ".cr2", ".cr3", ".crw", ".arw", ".srf", ".sr2",
      ".raf", ".orf", ".rw2", ".rwl", ".pef", ".srw", ".erf", ".kdc", ".dcr",
      ".mrw", ".mef", ".mos", ".iiq", ".3fr", ".fff", ".x3f", ".raw"};
  const std::string extension = Lower(path.extension().string());
  return std::find(kRaw.begin(), kRaw.end(), extension) != kRaw.end();
}

// The format, by the first bytes; for RAW, of which most call themselves TIFF, by the
// name.
std::optional<PictureFormat> SniffFormat(const fs::path& path, std::string_view head) {
  const auto starts = [&](std::string_view magic, std::size_t at = 0) {
    return head.size() >= at + magic.size() && head.substr(at, magic.size()) == magic;
  };
  if (starts("\xFF\xD8\xFF")) return PictureFormat::kJpeg;
  if (starts("\x89PNG\r\n\x1A\n")) return PictureFormat::kPng;
  if (starts("\x76\x2F\x31\x01")) return PictureFormat::kExr;
  if (starts("#?RADIANCE") || starts("#?RGBE")) return PictureFormat::kHdr;
  if (starts("ftypcrx", 4)) return PictureFormat::kRaw;
  if (starts("ftyp", 4)) return PictureFormat::kHeif;
  if (HasRawExtension(path)) return PictureFormat::kRaw;
  using std::string_view_literals::operator""sv;
  if (starts("II*\0"sv) || starts("MM\0*"sv) || starts("II+\0"sv) || starts("MM\0+"sv)) {
    return PictureFormat::kTiff;
  }
  return std::nullopt;
}

const char* ReaderName(PictureFormat format) {
  switch (format) {
    case PictureFormat::kJpeg:
      return "jpeg";
    case PictureFormat::kPng:
      return "png";
    case PictureFormat::kTiff:
      return "tiff";
    case PictureFormat::kHeif:
      return "heif";
    case PictureFormat::kRaw:
      return "raw";
    case PictureFormat::kExr:
      return "openexr";
    case PictureFormat::kHdr:
      return "hdr";
  }
  return "";
}

// Whether the marker segments of a JPEG lead to its end-of-image marker. Decoders fill
// what is missing with grey and call it a warning. Thumbnails lie inside a segment, so
// their own end markers do not count; what follows the end (a second picture) does not
// either.
bool JpegIsWhole(std::string_view bytes) {
  const auto at = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
  std::size_t i = 2;
  while (true) {
    // The next marker: FF and anything but 00 (a stuffed FF) and D0-D7 (restarts)
    while (i + 1 < bytes.size() &&
           (at(i) != 0xFF || at(i + 1) == 0xFF || at(i + 1) == 0x00 ||
            at(i + 1) == 0x01 || (at(i + 1) >= 0xD0 && at(i + 1) <= 0xD7))) {
      const void* next = std::memchr(bytes.data() + i + 1, 0xFF, bytes.size() - i - 1);
      if (next == nullptr) return false;
      i = static_cast<std::size_t>(static_cast<const char*>(next) - bytes.data());
    }
    if (i + 1 >= bytes.size()) return false;
    if (at(i + 1) == 0xD9) return true;

    // Over its segment
    if (i + 3 >= bytes.size()) return false;
    i += 2 + static_cast<std::size_t>(at(i + 2) << 8 | at(i + 3));
    if (i >= bytes.size()) return false;
  }
}

// Whether the chunks of a PNG lead to IEND, which is whole too.
bool PngIsWhole(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::error_code status;
  const std::uintmax_t size = fs::file_size(path, status);
  std::uintmax_t at = 8;
  while (at + 12 <= size) {
    unsigned char head[8];
    in.seekg(static_cast<std::streamoff>(at));
    if (!in.read(reinterpret_cast<char*>(head), sizeof head)) return false;
    const std::uintmax_t length = static_cast<std::uintmax_t>(head[0]) << 24 |
                                  head[1] << 16 | head[2] << 8 | head[3];
    at += 12 + length;
    if (std::memcmp(head + 4, "IEND", 4) == 0) return at <= size;
  }
  return false;
}

// Of what a decoder said in the end, whether it means lost pixels. "Extraneous bytes" and
// the like are habits of some cameras.
bool MeansLostPixels(const std::string& messages) {
  const std::string text = Lower(messages);
  for (const char* sign : {"premature end",
                           "bad huffman",
                           "bad arithmetic",
                           "instead of rst",
                           "unsupported marker",
                           "read error",
                           "corrupt data"}) {
    if (text.find(sign) != std::string::npos) return true;
  }
  return false;
}

std::string FirstLine(const std::string& text) { return text.substr(0, text.find('\n')); }

OIIO::TypeDesc SampleType(int depth) {
  return depth == CV_8U    ? OIIO::TypeDesc::UINT8
         : depth == CV_16U ? OIIO::TypeDesc::UINT16
                           : OIIO::TypeDesc::FLOAT;
}

// What OpenImageIO leaves out of a HEIC.
void AddHeifMetadata(const fs::path& path, OIIO::ImageSpec& spec) {
  constexpr char kProfile[] = "ICCProfile:profile_description";
  constexpr int kDisplayP3 = 12;  // Of ITU-T H.273
  const HeifMetadata metadata = ReadHeifMetadata(path);
  if (!metadata.exif.empty()) OIIO::decode_exif(OIIO::string_view(metadata.exif), spec);
  if (!metadata.icc.empty()) {
    std::string error;
    using Bytes = OIIO::cspan<std::uint8_t>;
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(metadata.icc.data());
    const auto size = static_cast<Bytes::size_type>(metadata.icc.size());
    OIIO::decode_icc_profile(Bytes(bytes, size), spec, error);
    const auto count = static_cast<int>(metadata.icc.size());
    spec.attribute("ICCProfile", OIIO::TypeDesc(OIIO::TypeDesc::UINT8, count), bytes);
  } else if (metadata.primaries == kDisplayP3) {
    spec.attribute(kProfile, "Display P3");
  }
}

}  // namespace

void PictureFile::Refuse(const std::string& why) const {
  throw InputError(path_.string() + ": " + why);
}

void PictureFile::RefuseDamaged(const std::string& detail) const {
  Refuse("is cut off or damaged" +
         (detail.empty() ? "" : " (" + FirstLine(detail) + ")") +
         "; copy it again from the camera or card, or save it again");
}

PictureFile::PictureFile(const fs::path& path, bool takes_hdr)
    : path_(path), input_(new Input) {
  // What is there at all
  std::error_code status;
  if (!fs::exists(path, status)) Refuse("no such file; check the name");
  if (fs::is_directory(path, status)) Refuse("is a folder; give a picture file");
  std::string head(16, '\0');
  std::ifstream in(path, std::ios::binary);
  if (!in)
    Refuse(std::string("cannot be read: ") + std::generic_category().message(errno));
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  in.close();
  if (head.empty()) Refuse("is empty; copy it again");
  const std::optional<PictureFormat> format = SniffFormat(path, head);
  if (!format) {
    Refuse(std::string("is not a picture that relight knows, whatever its name says; ") +
           kFormats);
  }
  format_ = *format;
  if (format_ == PictureFormat::kHdr && !takes_hdr) {
    Refuse(
        "is a Radiance .hdr, which relight takes as a panorama of the sky alone (--sky "
        "panorama:FILE); save it as OpenEXR");
  }

  // Cut off, as the file's own structure says
  if (format_ == PictureFormat::kJpeg && !JpegIsWhole(ReadText(path))) RefuseDamaged("");
  if (format_ == PictureFormat::kPng && !PngIsWhole(path)) RefuseDamaged("");

  // Straight alpha as it is in the file; RAW developed to linear light
  OIIO::ImageSpec hints;
  hints.attribute("oiio:UnassociatedAlpha", 1);
  hints.attribute("raw:ColorSpace", "linear");
  hints.attribute("raw:use_camera_wb", 1);
  input_->reader = OIIO::ImageInput::create(ReaderName(format_));
  if (!input_->reader) {
    OIIO::geterror();
    Refuse(std::string("this OpenImageIO was built without ") + ReaderName(format_) +
           "; convert the picture to TIFF or JPEG first");
  }
  OIIO::ImageSpec& spec = input_->spec;
  if (!input_->reader->open(path.string(), spec, hints)) {
    RefuseDamaged(input_->reader->geterror());
  }
  if (format_ == PictureFormat::kHeif) AddHeifMetadata(path, spec);
  if (spec.deep) Refuse("is a deep EXR; flatten it first");

  const bool is_exr = format_ == PictureFormat::kExr;
  size_ = is_exr ? cv::Size(spec.full_width, spec.full_height)
                 : cv::Size(spec.width, spec.height);
  depth_ = spec.format == OIIO::TypeDesc::UINT8    ? CV_8U
           : spec.format == OIIO::TypeDesc::UINT16 ? CV_16U
                                                   : CV_32F;
  channels_ = spec.channelnames;
  alpha_channel_ = spec.alpha_channel;
  is_premultiplied_ =
      alpha_channel_ >= 0 &&
      (is_exr || (format_ == PictureFormat::kTiff &&
                  spec.get_int_attribute("oiio:UnassociatedAlpha", 0) == 0));

  // The decoders of HEIC and RAW turn the picture themselves
  if (format_ != PictureFormat::kHeif && format_ != PictureFormat::kRaw) {
    const int orientation = spec.get_int_attribute("Orientation", 1);
    orientation_ = orientation >= 1 && orientation <= 8 ? orientation : 1;
  }
  const auto says_cmyk = [&](const char* name) {
    const std::string text = Lower(spec.get_string_attribute(name));
    return text.find("cmyk") != std::string::npos ||
           text.find("ycck") != std::string::npos;
  };
  constexpr int kSeparated = 5;  // PHOTOMETRIC_SEPARATED of TIFF
  is_cmyk_ = says_cmyk("jpeg:ColorSpace") || says_cmyk("tiff:ColorSpace") ||
             spec.get_int_attribute("tiff:PhotometricInterpretation", -1) == kSeparated;
}

PictureFile::~PictureFile() = default;

std::optional<std::string> PictureFile::Text(const std::string& name) const {
  const OIIO::ParamValue* found = input_->spec.find_attribute(name);
  if (found == nullptr || found->type() != OIIO::TypeString) return std::nullopt;
  return found->get_string();
}

std::string PictureFile::Bytes(const std::string& name) const {
  const OIIO::ParamValue* found = input_->spec.find_attribute(name);
  if (found == nullptr || found->type().basetype != OIIO::TypeDesc::UINT8) return {};
  return {static_cast<const char*>(found->data()),
          static_cast<std::size_t>(found->datasize())};
}

std::vector<double> PictureFile::Numbers(const std::string& name) const {
  const OIIO::ParamValue* found = input_->spec.find_attribute(name);
  std::vector<double> numbers;
  if (found == nullptr || found->type().basetype == OIIO::TypeDesc::STRING)
    return numbers;
  const OIIO::TypeDesc type = found->type();
  const int count = static_cast<int>(type.numelements()) * type.aggregate;
  for (int i = 0; i < count; ++i) {
    switch (type.basetype) {
      case OIIO::TypeDesc::FLOAT:
        numbers.push_back(static_cast<const float*>(found->data())[i]);
        break;
      case OIIO::TypeDesc::DOUBLE:
        numbers.push_back(static_cast<const double*>(found->data())[i]);
        break;
      default:
        numbers.push_back(found->get_int_indexed(i));
    }
  }
  return numbers;
}

std::vector<std::string> PictureFile::TextNames() const {
  std::vector<std::string> names;
  for (const OIIO::ParamValue& each : input_->spec.extra_attribs) {
    if (each.type() == OIIO::TypeString) names.push_back(each.name().string());
  }
  return names;
}

void PictureFile::CheckSize() const {
  const double pixels = static_cast<double>(size_.width) * size_.height;
  if (size_.width < 1 || size_.height < 1 || pixels > kMaxPixels) {
    Refuse("says it is " + std::to_string(size_.width) + " x " +
           std::to_string(size_.height) +
           " pixels; relight takes pictures of 1 to 1000000000 pixels");
  }
}

void PictureFile::ReadBands(
    const std::function<void(int first_row, const cv::Mat& band)>& take,
    const Progress& progress) {
  CheckSize();
  OIIO::ImageInput& reader = *input_->reader;
  const OIIO::ImageSpec& spec = input_->spec;
  const int count = static_cast<int>(channels_.size());
  if (count < 1 || count > CV_CN_MAX || spec.depth > 1) {
    Refuse("has " + std::to_string(count) + " channels, which no photo has");
  }
  const int type = CV_MAKETYPE(depth_, count);
  const OIIO::TypeDesc sample = SampleType(depth_);

  // Where the stored pixels lie in the picture: elsewhere than everywhere only in an EXR,
  // whose data window need not be its display window
  const bool is_exr = format_ == PictureFormat::kExr;
  const cv::Rect stored(is_exr ? spec.x - spec.full_x : 0,
                        is_exr ? spec.y - spec.full_y : 0,
                        spec.width,
                        spec.height);
  const cv::Rect picture(cv::Point(0, 0), size_);
  const cv::Rect shown = stored & picture;
  const int tile = spec.tile_height;
  const int step = tile > 0 ? (kBandRows + tile - 1) / tile * tile : kBandRows;

  const cv::Mat outside =
      stored == picture ? cv::Mat()
                        : cv::Mat::zeros(std::min(step, size_.height), size_.width, type);
  // What is above and below the stored rows
  const auto take_nothing = [&](int from, int to) {
    for (int y = from; y < to; y += step) {
      take(y, outside.rowRange(0, std::min(step, to - y)));
    }
  };
  if (shown.empty()) {
    take_nothing(0, size_.height);
    return;
  }
  take_nothing(0, shown.y);
  cv::Mat rows(std::min(step, stored.height), stored.width, type);
  for (int y = 0; y < stored.height; y += step) {
    const int end = std::min(y + step, stored.height);
    const bool read =
        tile > 0
            ? reader.read_tiles(0,
                                0,
                                spec.x,
                                spec.x + spec.width,
                                spec.y + y,
                                spec.y + end,
                                spec.z,
                                spec.z + 1,
                                0,
                                count,
                                sample,
                                rows.data)
            : reader.read_scanlines(
                  0, 0, spec.y + y, spec.y + end, spec.z, 0, count, sample, rows.data);
    if (!read) RefuseDamaged(reader.geterror());

    // The part of these rows that is in the picture
    const int top = std::max(stored.y + y, 0);
    const int bottom = std::min(stored.y + end, size_.height);
    if (top < bottom) {
      const cv::Mat part = rows.rowRange(top - stored.y - y, bottom - stored.y - y);
      if (outside.empty()) {
        take(top, part);
      } else {
        cv::Mat whole = cv::Mat::zeros(bottom - top, size_.width, type);
        part.colRange(shown.x - stored.x, shown.x - stored.x + shown.width)
            .copyTo(whole.colRange(shown.x, shown.x + shown.width));
        take(top, whole);
      }
    }
    progress.Report(static_cast<double>(end) / stored.height);
  }
  take_nothing(shown.y + shown.height, size_.height);
  if (const std::string said = reader.geterror(); MeansLostPixels(said))
    RefuseDamaged(said);
}

// EXIF: where row 0 and column 0 of the stored picture are when it stands upright.
cv::Mat ApplyOrientation(const cv::Mat& stored, int orientation) {
  cv::Mat upright;
  switch (orientation) {
    case 2:
      cv::flip(stored, upright, 1);
      return upright;  // Mirrored
    case 3:
      cv::flip(stored, upright, -1);
      return upright;  // Upside down
    case 4:
      cv::flip(stored, upright, 0);
      return upright;
    case 5:
      cv::transpose(stored, upright);
      return upright;
    case 6:
      cv::rotate(stored, upright, cv::ROTATE_90_CLOCKWISE);
      return upright;
    case 7: {  // Transposed along the other diagonal
      cv::transpose(stored, upright);
      cv::flip(upright, upright, -1);
      return upright;
    }
    case 8:
      cv::rotate(stored, upright, cv::ROTATE_90_COUNTERCLOCKWISE);
      return upright;
    default:
      return stored;
  }
}

cv::Size UprightSize(cv::Size stored, int orientation) {
  return orientation >= 5 ? cv::Size(stored.height, stored.width) : stored;
}

}  // namespace relight
