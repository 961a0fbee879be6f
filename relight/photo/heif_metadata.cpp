// SPDX-License-Identifier: Apache-2.0
#include "relight/photo/heif_metadata.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string_view>
#include <vector>

namespace relight {
namespace {

// Largest that is read: a phone's are some 10 and 3 kB, thumbnails in EXIF included.
constexpr std::uint64_t kMostMeta = 16'000'000, kMostExif = 16'000'000;

// Big-endian numbers one after another. Past the end all are 0 and `ok` is false.
struct Cursor {
  std::string_view bytes;
  bool ok = true;

  std::uint64_t Take(unsigned count) {
    if (count > bytes.size()) {
      ok = false;
      bytes = {};
      return 0;
    }
    std::uint64_t value = 0;
    for (const char c : bytes.substr(0, count))
      value = value << 8 | static_cast<unsigned char>(c);
    bytes.remove_prefix(count);
    return value;
  }
  std::string_view TakeBytes(std::uint64_t count) {
    if (count > bytes.size()) {
      ok = false;
      return {};
    }
    const auto taken = bytes.substr(0, static_cast<std::size_t>(count));
    bytes.remove_prefix(taken.size());
    return taken;
  }
};

struct Box {
  std::string_view type, content;
};

// The next box; none at the end, and of one that is longer than what holds it.
std::optional<Box> NextBox(Cursor& in) {
  if (in.bytes.empty()) return {};
  std::uint64_t size = in.Take(4), head = 8;
  const std::string_view type = in.TakeBytes(4);
  if (size == 1) {
    size = in.Take(8);
    head = 16;
  } else if (size == 0) {
    size = head + in.bytes.size();
  }
  if (!in.ok || size < head) return {};
  const std::string_view content = in.TakeBytes(size - head);
  if (!in.ok) return {};
  return Box{type, content};
}

// The content of the first box of a type.
std::optional<std::string_view> Find(std::string_view boxes, std::string_view type) {
  Cursor in{boxes};
  while (const auto box = NextBox(in)) {
    if (box->type == type) return box->content;
  }
  return {};
}

std::uint64_t PrimaryItem(std::string_view meta) {
  Cursor in{Find(meta, "pitm").value_or("")};
  const std::uint64_t version = in.Take(1);
  in.Take(3);
  return in.Take(version == 0 ? 2 : 4);
}

std::optional<std::uint64_t> ExifItem(std::string_view meta) {
  Cursor in{Find(meta, "iinf").value_or("")};
  const std::uint64_t version = in.Take(1);
  in.Take(3);
  in.Take(version == 0 ? 2 : 4);
  while (const auto entry = NextBox(in)) {
    Cursor item{entry->content};
    const std::uint64_t entry_version = item.Take(1);
    item.Take(3);
    if (entry->type != "infe" || entry_version < 2) continue;
    const std::uint64_t id = item.Take(entry_version == 2 ? 2 : 4);
    item.Take(2);
    if (item.TakeBytes(4) == "Exif") return id;
  }
  return {};
}

// The bytes of an item: pieces of the file, or of the idat box beside the item's place.
std::string ItemBytes(std::ifstream& file, std::string_view meta, std::uint64_t wanted) {
  Cursor in{Find(meta, "iloc").value_or("")};
  const std::uint64_t version = in.Take(1);
  in.Take(3);
  const auto sizes = static_cast<unsigned>(in.Take(2));
  const unsigned offset_size = sizes >> 12, length_size = sizes >> 8 & 15,
                 base_size = sizes >> 4 & 15, index_size = version == 0 ? 0 : sizes & 15;
  const std::uint64_t items = in.Take(version < 2 ? 2 : 4);
  for (std::uint64_t i = 0; i < items && in.ok; ++i) {
    const std::uint64_t id = in.Take(version < 2 ? 2 : 4);
    const std::uint64_t where = version == 0 ? 0 : in.Take(2) & 15;
    in.Take(2);
    const std::uint64_t base = in.Take(base_size), pieces = in.Take(2);
    std::string bytes;
    for (std::uint64_t piece = 0; piece < pieces && in.ok; ++piece) {
      in.Take(index_size);
      const std::uint64_t at = base + in.Take(offset_size), length = in.Take(length_size);
      if (id != wanted || !in.ok) continue;
      if (length > kMostExif - bytes.size()) return {};
      if (where == 1) {
        const std::string_view idat = Find(meta, "idat").value_or("");
        if (at > idat.size()) return {};
        bytes +=
            idat.substr(static_cast<std::size_t>(at), static_cast<std::size_t>(length));
      } else if (where == 0) {
        std::string read(static_cast<std::size_t>(length), '\0');
        file.clear();
        file.seekg(static_cast<std::streamoff>(at));
        if (!file.read(read.data(), static_cast<std::streamsize>(length))) return {};
        bytes += read;
      }
    }
    if (id == wanted) return bytes;
  }
  return {};
}

// Which of the properties in ipco belong to an item, counted from 1.
std::vector<std::uint64_t> PropertiesOf(std::uint64_t wanted, std::string_view ipma) {
  Cursor in{ipma};
  const std::uint64_t version = in.Take(1), flags = in.Take(3), entries = in.Take(4);
  for (std::uint64_t i = 0; i < entries && in.ok; ++i) {
    const std::uint64_t id = in.Take(version == 0 ? 2 : 4), count = in.Take(1);
    std::vector<std::uint64_t> indices;
    for (std::uint64_t k = 0; k < count && in.ok; ++k) {
      indices.push_back((flags & 1) != 0 ? in.Take(2) & 0x7FFF : in.Take(1) & 0x7F);
    }
    if (id == wanted) return indices;
  }
  return {};
}

void ReadColor(std::string_view meta, HeifMetadata& metadata) {
  const std::string_view properties = Find(meta, "iprp").value_or("");
  const auto of_primary =
      PropertiesOf(PrimaryItem(meta), Find(properties, "ipma").value_or(""));
  Cursor in{Find(properties, "ipco").value_or("")};
  for (std::uint64_t index = 1; const auto box = NextBox(in); ++index) {
    const bool is_ours =
        std::find(of_primary.begin(), of_primary.end(), index) != of_primary.end();
    if (box->type != "colr" || !is_ours) continue;
    Cursor color{box->content};
    const std::string_view kind = color.TakeBytes(4);
    if (kind == "nclx") metadata.primaries = static_cast<int>(color.Take(2));
    if (kind == "prof" || kind == "rICC") metadata.icc = std::string(color.bytes);
  }
}

// The item's first 4 bytes say how far behind them the TIFF begins.
std::string TiffOf(std::string_view item) {
  Cursor in{item};
  in.TakeBytes(in.Take(4));
  return in.ok ? std::string(in.bytes) : std::string();
}

}  // namespace

HeifMetadata ReadHeifMetadata(const std::filesystem::path& path) {
  HeifMetadata metadata;
  std::ifstream file(path, std::ios::binary);
  std::uint64_t at = 0;
  while (file) {
    // A box of the file itself: 16 bytes hold its head
    std::string head(16, '\0');
    file.seekg(static_cast<std::streamoff>(at));
    file.read(head.data(), 16);
    head.resize(static_cast<std::size_t>(file.gcount()));
    Cursor in{head};
    std::uint64_t size = in.Take(4), begin = 8;
    const std::string_view type = in.TakeBytes(4);
    if (size == 1) {
      size = in.Take(8);
      begin = 16;
    }
    if (!in.ok || size < begin || size > UINT64_MAX / 2 - at) break;
    if (type != "meta") {
      at += size;
      continue;
    }
    if (size - begin < 4 || size - begin > kMostMeta) break;
    std::string content(static_cast<std::size_t>(size - begin), '\0');
    file.clear();
    file.seekg(static_cast<std::streamoff>(at + begin));
    if (!file.read(content.data(), static_cast<std::streamsize>(content.size()))) break;
    const std::string_view meta = std::string_view(content).substr(4);
    ReadColor(meta, metadata);
    if (const auto exif = ExifItem(meta)) {
      metadata.exif = TiffOf(ItemBytes(file, meta, *exif));
    }
    break;
  }
  return metadata;
}

}  // namespace relight
