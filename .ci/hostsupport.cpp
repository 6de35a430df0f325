// A small OpenFX host on the HostSupport library of the OpenFX project, on which Natron is built.
//
// In: OFX_PLUGIN_PATH, the folder of PinWarp.ofx.bundle; a folder for what buttons write. Out: what is wrong, line by
// line, and exit status 1. The picture is black with a bright dot under a pin: where the pin goes, the dot must be.
#include "ofxCore.h"
#include "ofxImageEffect.h"
#include "ofxhBinary.h"
#include "ofxhPropertySuite.h"
#include "ofxhClip.h"
#include "ofxhParam.h"
#include "ofxhMemory.h"
#include "ofxhImageEffect.h"
#include "ofxhPluginAPICache.h"
#include "ofxhPluginCache.h"
#include "ofxhHost.h"
#include "ofxhImageEffectAPI.h"
#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

using namespace OFX::Host;
using std::string;
typedef std::pair<double, double> Point;

static int faults = 0;
static void check(bool is_right, const string &what) {
  if (!is_right) { ++faults; std::printf("WRONG: %s\n", what.c_str()); }
}

// The picture: pixels at full size, their aspect, how far they are scaled down.
static const int WIDTH = 320, HEIGHT = 180;
static double aspect = 1, scale = 1;
static OfxRectD source_rod = {0, 0, WIDTH, HEIGHT};
static const Point PIN(160, 90), TARGET(200, 110);

static OfxRectI pixels_of(const OfxRectD &r) {
  const double across = scale / aspect;
  OfxRectI p = {int(std::floor(r.x1 * across)), int(std::floor(r.y1 * scale)), int(std::ceil(r.x2 * across)),
                int(std::ceil(r.y2 * scale))};
  return p;
}

/// A value with keys; between keys the last one holds.
template <class Base, class T> struct Keyed : Base {
  T value;
  std::map<OfxTime, T> keys;
  Keyed(Param::Descriptor &d, Param::SetInstance *set, T start) : Base(d, set), value(start) {}
  T at(OfxTime t) const {
    typename std::map<OfxTime, T>::const_iterator after = keys.upper_bound(t);
    return keys.empty() ? value : after == keys.begin() ? after->second : (--after)->second;
  }
  OfxStatus put(T v) { if (keys.empty()) value = v; else keys[0] = v; return kOfxStatOK; }
  OfxStatus put(OfxTime t, T v) {
    keys[t] = v;
    this->getProperties().setIntProperty(kOfxParamPropIsAnimating, 1);
    return kOfxStatOK;
  }
  OfxStatus getNumKeys(unsigned int &n) const override { n = keys.size(); return kOfxStatOK; }
  OfxStatus getKeyTime(int nth, OfxTime &time) const override {
    if (nth < 0 || size_t(nth) >= keys.size()) return kOfxStatErrBadIndex;
    time = std::next(keys.begin(), nth)->first;
    return kOfxStatOK;
  }
  OfxStatus deleteAllKeys() override {
    keys.clear();
    this->getProperties().setIntProperty(kOfxParamPropIsAnimating, 0);
    return kOfxStatOK;
  }
};
template <class Base, class T> struct Single : Keyed<Base, T> {
  using Keyed<Base, T>::Keyed;
  OfxStatus get(T &v) override { v = this->at(0); return kOfxStatOK; }
  OfxStatus get(OfxTime t, T &v) override { v = this->at(t); return kOfxStatOK; }
  OfxStatus set(T v) override { return this->put(v); }
  OfxStatus set(OfxTime t, T v) override { return this->put(t, v); }
};
typedef Single<Param::IntegerInstance, int> Int;
typedef Single<Param::ChoiceInstance, int> Choice;
typedef Single<Param::BooleanInstance, bool> Bool;
struct Double : Single<Param::DoubleInstance, double> {
  using Single::Single;
  OfxStatus derive(OfxTime, double &) override { return kOfxStatErrUnsupported; }
  OfxStatus integrate(OfxTime, OfxTime, double &) override { return kOfxStatErrUnsupported; }
};
struct Double2D : Keyed<Param::Double2DInstance, Point> {
  using Keyed::Keyed;
  OfxStatus get(double &x, double &y) override { x = at(0).first; y = at(0).second; return kOfxStatOK; }
  OfxStatus get(OfxTime t, double &x, double &y) override { x = at(t).first; y = at(t).second; return kOfxStatOK; }
  OfxStatus set(double x, double y) override { return put(Point(x, y)); }
  OfxStatus set(OfxTime t, double x, double y) override { return put(t, Point(x, y)); }
};
struct Text : Keyed<Param::StringInstance, string> {
  using Keyed::Keyed;
  OfxStatus get(string &v) override { v = at(0); return kOfxStatOK; }
  OfxStatus get(OfxTime t, string &v) override { v = at(t); return kOfxStatOK; }
  OfxStatus set(const char *v) override { return put(v); }
  OfxStatus set(OfxTime t, const char *v) override { return put(t, v); }
};

/// Floats, red first, in rows from below.
struct Picture : ImageEffect::Image {
  OfxRectI bounds;
  std::vector<float> data;
  Picture(ImageEffect::ClipInstance &clip, const OfxRectI &b)
      : Image(clip), bounds(b), data(size_t(4) * (b.x2 - b.x1) * (b.y2 - b.y1)) {
    setDoubleProperty(kOfxImageEffectPropRenderScale, scale, 0);
    setDoubleProperty(kOfxImageEffectPropRenderScale, scale, 1);
    setPointerProperty(kOfxImagePropData, data.data());
    setIntPropertyN(kOfxImagePropBounds, &b.x1, 4);
    setIntPropertyN(kOfxImagePropRegionOfDefinition, &b.x1, 4);
    setIntProperty(kOfxImagePropRowBytes, (b.x2 - b.x1) * 16);
  }
  float *at(int x, int y) { return &data[4 * (size_t(y - bounds.y1) * (bounds.x2 - bounds.x1) + (x - bounds.x1))]; }
  /// The brightest pixel's centre, canonical.
  Point brightest() {
    Point best(-1, -1);
    float most = 0;
    for (int y = bounds.y1; y < bounds.y2; ++y)
      for (int x = bounds.x1; x < bounds.x2; ++x)
        if (at(x, y)[0] > most) { most = at(x, y)[0]; best = Point((x + .5) / scale * aspect, (y + .5) / scale); }
    return best;
  }
};

struct Clip : ImageEffect::ClipInstance {
  string premult, none = kOfxImageFieldNone, depth = kOfxBitDepthFloat, rgba = kOfxImageComponentRGBA;
  Picture *output = nullptr;
  Clip(ImageEffect::Instance *effect, ImageEffect::ClipDescriptor *d)
      : ClipInstance(effect, *d), premult(kOfxImagePreMultiplied) {}
  ~Clip() override { if (output) output->releaseReference(); }
  const string &getUnmappedBitDepth() const override { return depth; }
  const string &getUnmappedComponents() const override { return rgba; }
  const string &getPremult() const override {
    return isOutput() ? _effectInstance->getOutputPreMultiplication() : premult;
  }
  double getAspectRatio() const override { return aspect; }
  double getFrameRate() const override { return 24; }
  void getFrameRange(double &a, double &b) const override { a = 1; b = 3; }
  const string &getFieldOrder() const override { return none; }
  bool getConnected() const override { return isOutput() || getName() == "Source"; }
  double getUnmappedFrameRate() const override { return 24; }
  void getUnmappedFrameRange(double &a, double &b) const override { a = 1; b = 3; }
  bool getContinuousSamples() const override { return false; }
  OfxRectD getRegionOfDefinition(OfxTime) const override { return source_rod; }
  ImageEffect::Image *getImage(OfxTime, const OfxRectD *) override {
    if (isOutput()) {
      if (output) output->addReference();
      return output;
    }
    const OfxRectD frame = {0, 0, WIDTH, HEIGHT};
    Picture *picture = new Picture(*this, pixels_of(frame));
    const double reach = 3;
    for (int y = picture->bounds.y1; y < picture->bounds.y2; ++y)
      for (int x = picture->bounds.x1; x < picture->bounds.x2; ++x) {
        const double dx = (x + .5) / scale * aspect - PIN.first, dy = (y + .5) / scale - PIN.second;
        float *p = picture->at(x, y);
        p[0] = p[1] = p[2] = float(std::exp(-(dx * dx + dy * dy) / (2 * reach * reach)));
        p[3] = 1;
      }
    return picture;
  }
  Picture *fresh(const OfxRectI &bounds) {
    if (output) output->releaseReference();
    return output = new Picture(*this, bounds);
  }
};

struct Effect : ImageEffect::Instance {
  string none = kOfxImageFieldNone;
  int edits = 0, redraws = 0;
  std::vector<string> said;
  Effect(ImageEffect::ImageEffectPlugin *p, ImageEffect::Descriptor &d, const string &c) : Instance(p, d, c, true) {}
  const string &getDefaultOutputFielding() const override { return none; }
  ImageEffect::ClipInstance *newClipInstance(ImageEffect::Instance *, ImageEffect::ClipDescriptor *d, int) override {
    return new Clip(this, d);
  }
  OfxStatus vmessage(const char *type, const char *, const char *format, va_list args) override {
    char text[2000];
    std::vsnprintf(text, sizeof text, format, args);
    said.push_back(string(type) + ": " + text);
    return kOfxStatOK;
  }
  OfxStatus setPersistentMessage(const char *t, const char *i, const char *f, va_list a) override {
    return vmessage(t, i, f, a);
  }
  OfxStatus clearPersistentMessage() override { return kOfxStatOK; }
  void getProjectSize(double &x, double &y) const override { x = WIDTH; y = HEIGHT; }
  void getProjectOffset(double &x, double &y) const override { x = y = 0; }
  void getProjectExtent(double &x, double &y) const override { x = WIDTH; y = HEIGHT; }
  double getProjectPixelAspectRatio() const override { return aspect; }
  double getEffectDuration() const override { return 3; }
  double getFrameRate() const override { return 24; }
  double getFrameRecursive() const override { return 1; }
  void getRenderScaleRecursive(double &x, double &y) const override { x = y = scale; }
  OfxStatus editBegin(const string &) override { ++edits; return kOfxStatOK; }
  OfxStatus editEnd() override { --edits; return kOfxStatOK; }
  void progressStart(const string &, const string &) override {}
  void progressEnd() override {}
  bool progressUpdate(double) override { return true; }
  double timeLineGetTime() override { return 1; }
  void timeLineGotoTime(double) override {}
  void timeLineGetBounds(double &a, double &b) override { a = 1; b = 3; }
  Param::Instance *newParam(const string &, Param::Descriptor &d) override {
    const string &type = d.getType();
    const Property::Set &props = d.getProperties();
    if (type == kOfxParamTypeInteger) return new Int(d, this, props.getIntProperty(kOfxParamPropDefault));
    if (type == kOfxParamTypeChoice) return new Choice(d, this, props.getIntProperty(kOfxParamPropDefault));
    if (type == kOfxParamTypeBoolean) return new Bool(d, this, props.getIntProperty(kOfxParamPropDefault) != 0);
    if (type == kOfxParamTypeDouble) return new Double(d, this, props.getDoubleProperty(kOfxParamPropDefault));
    if (type == kOfxParamTypeString) return new Text(d, this, props.getStringProperty(kOfxParamPropDefault));
    if (type == kOfxParamTypeDouble2D) {
      const double x = props.getDoubleProperty(kOfxParamPropDefault, 0);
      return new Double2D(d, this, Point(x, props.getDoubleProperty(kOfxParamPropDefault, 1)));
    }
    if (type == kOfxParamTypeGroup) return new Param::GroupInstance(d, this);
    if (type == kOfxParamTypePage) return new Param::PageInstance(d, this);
    if (type == kOfxParamTypePushButton) return new Param::PushbuttonInstance(d, this);
    check(false, "a parameter of type " + type);
    return nullptr;
  }
  template <class T> T &param(const string &id) {
    T *found = dynamic_cast<T *>(getParam(id));
    if (!found) { std::printf("no parameter %s\n", id.c_str()); std::exit(2); }
    return *found;
  }
  Clip &clip(const char *name) { return dynamic_cast<Clip &>(*getClip(name)); }
  OfxPointD scales() const { OfxPointD s = {scale, scale}; return s; }
  OfxStatus edited(const string &id) {
    beginInstanceChangedAction(kOfxChangeUserEdited);
    const OfxStatus status = paramInstanceChangedAction(id, kOfxChangeUserEdited, 1, scales());
    endInstanceChangedAction(kOfxChangeUserEdited);
    return status;
  }
  OfxRectD region() {
    OfxRectD rod = {0, 0, 0, 0};
    const OfxStatus status = getRegionOfDefinitionAction(1, scales(), rod);
    check(status == kOfxStatOK || status == kOfxStatReplyDefault, "region of definition");
    return rod;
  }
  OfxStatus render(const OfxRectI &window, const string &field = kOfxImageFieldNone) {
    const double across = aspect / scale;
    const OfxRectD roi = {window.x1 * across, window.y1 / scale, window.x2 * across, window.y2 / scale};
    std::map<ImageEffect::ClipInstance *, OfxRectD> rois;
    check(getRegionOfInterestAction(1, scales(), roi, rois) == kOfxStatOK, "regions of interest");
    return renderAction(1, field, window, scales(), true, true, false);
  }
  bool is_identity() {
    OfxTime time = 1;
    const OfxRectI window = {0, 0, WIDTH, HEIGHT};
    string clip;
    return isIdentityAction(time, kOfxImageFieldNone, window, scales(), clip) == kOfxStatOK && clip == "Source";
  }
};

struct Program : ImageEffect::Host {
  explicit Program(bool has_overlays) {
    Property::Set &p = _properties;
    p.setIntProperty(kOfxPropAPIVersion, 1, 0);
    p.setIntProperty(kOfxPropAPIVersion, 4, 1);
    p.setStringProperty(kOfxPropName, "org.pinwarp.check");
    p.setStringProperty(kOfxPropLabel, "Check");
    p.setIntProperty(kOfxImageEffectPropSupportsOverlays, has_overlays);
    p.setIntProperty(kOfxImageEffectPropSupportsMultiResolution, 1);
    p.setIntProperty(kOfxImageEffectPropSupportsTiles, 1);
    p.setIntProperty(kOfxParamHostPropSupportsBooleanAnimation, 1);
    p.setIntProperty(kOfxParamHostPropMaxParameters, -1);
    const char *kinds[] = {kOfxImageComponentRGBA, kOfxImageComponentRGB, kOfxImageComponentAlpha};
    for (int i = 0; i < 3; ++i) p.setStringProperty(kOfxImageEffectPropSupportedComponents, kinds[i], i);
    p.setStringProperty(kOfxImageEffectPropSupportedContexts, kOfxImageEffectContextFilter, 0);
    p.setStringProperty(kOfxImageEffectPropSupportedContexts, kOfxImageEffectContextGeneral, 1);
    p.setStringProperty(kOfxImageEffectPropSupportedPixelDepths, kOfxBitDepthFloat, 0);
  }
  typedef ImageEffect::Descriptor Described;
  typedef ImageEffect::ImageEffectPlugin Plugin;
  ImageEffect::Instance *newInstance(void *, Plugin *p, Described &d, const string &c) override {
    return new Effect(p, d, c);
  }
  Described *makeDescriptor(Plugin *p) override { return new Described(p); }
  Described *makeDescriptor(const Described &root, Plugin *p) override { return new Described(root, p); }
  Described *makeDescriptor(const string &path, Plugin *p) override { return new Described(path, p); }
  OfxStatus vmessage(const char *type, const char *, const char *format, va_list args) override {
    std::printf("%s: ", type);
    std::vprintf(format, args);
    std::printf("\n");
    return kOfxStatOK;
  }
  OfxStatus setPersistentMessage(const char *t, const char *i, const char *f, va_list a) override {
    return vmessage(t, i, f, a);
  }
  OfxStatus clearPersistentMessage() override { return kOfxStatOK; }
#ifdef OFX_SUPPORTS_MULTITHREAD
  OfxStatus multiThread(OfxThreadFunctionV1 f, unsigned int, void *arg) override { f(0, 1, arg); return kOfxStatOK; }
  OfxStatus multiThreadNumCPUS(unsigned int *n) const override { *n = 1; return kOfxStatOK; }
  OfxStatus multiThreadIndex(unsigned int *n) const override { *n = 0; return kOfxStatOK; }
  int multiThreadIsSpawnedThread() const override { return 0; }
  OfxStatus mutexCreate(OfxMutexHandle *m, int) override { *m = 0; return kOfxStatOK; }
  OfxStatus mutexDestroy(const OfxMutexHandle) override { return kOfxStatOK; }
  OfxStatus mutexLock(const OfxMutexHandle) override { return kOfxStatOK; }
  OfxStatus mutexUnLock(const OfxMutexHandle) override { return kOfxStatOK; }
  OfxStatus mutexTryLock(const OfxMutexHandle) override { return kOfxStatOK; }
#endif
};

struct Overlay : ImageEffect::OverlayInteract {
  Effect &effect;
  explicit Overlay(Effect &e) : OverlayInteract(e), effect(e) {}
#ifdef kOfxInteractPropViewportSize
  void getViewportSize(double &w, double &h) const override { w = WIDTH; h = HEIGHT; }
#endif
  void getPixelScale(double &x, double &y) const override { x = y = 1; }
  void getBackgroundColour(double &r, double &g, double &b) const override { r = g = b = 0; }
  bool getSuggestedColour(double &, double &, double &) const override { return false; }
  OfxStatus swapBuffers() override { return kOfxStatOK; }
  OfxStatus redraw() override { ++effect.redraws; return kOfxStatOK; }
};

static bool near(Point a, Point b, double reach) {
  return std::hypot(a.first - b.first, a.second - b.second) <= reach;
}
static string told(Point p) { return "(" + std::to_string(p.first) + ", " + std::to_string(p.second) + ")"; }

static std::unique_ptr<Effect> made(ImageEffect::PluginCache &cache, const char *id, const char *context) {
  ImageEffect::ImageEffectPlugin *plugin = cache.getPluginById(id);
  if (!plugin) { std::printf("%s was not found\n", id); std::exit(2); }
  std::unique_ptr<Effect> effect(dynamic_cast<Effect *>(plugin->createInstance(context, nullptr)));
  if (!effect) { std::printf("%s makes no instance\n", id); std::exit(2); }
  check(effect->createInstanceAction() == kOfxStatOK, "create instance");
  check(effect->getClipPreferences(), "clip preferences");
  return effect;
}

/// Switches a pin on, which puts it into the middle, and pulls it to the target.
static void place_pin(Effect &effect) {
  effect.param<Bool>("pin1On").set(true);
  check(effect.edited("pin1On") == kOfxStatOK, "a pin is switched on");
  const Point placed = effect.param<Double2D>("pin1Rest").at(0);
  check(placed == PIN, "a new pin lies in the middle, not at " + told(placed));
  effect.param<Double2D>("pin1Target").set(TARGET.first, TARGET.second);
}

/// The dot is at the target; tiles and fields make up the same picture.
static void renders(Effect &effect, const string &what) {
  const OfxRectI all = pixels_of(effect.region());
  Picture &whole = *effect.clip("Output").fresh(all);
  check(effect.render(all) == kOfxStatOK, what + ": render");
  const Point found = whole.brightest();
  check(near(found, TARGET, 1.0 / scale * aspect), what + ": the dot is at " + told(found));
  const std::vector<float> pixels = whole.data;
  Picture &tiled = *effect.clip("Output").fresh(all);
  for (int y = all.y1; y < all.y2; y += 50)
    for (int x = all.x1; x < all.x2; x += 70) {
      const OfxRectI tile = {x, y, std::min(x + 70, all.x2), std::min(y + 50, all.y2)};
      check(effect.render(tile) == kOfxStatOK, what + ": a tile");
    }
  check(tiled.data == pixels, what + ": tiles differ from the whole");
  Picture &fields = *effect.clip("Output").fresh(all);
  effect.render(all, kOfxImageFieldLower);
  effect.render(all, kOfxImageFieldUpper);
  check(fields.data == pixels, what + ": fields differ from the frame");
  const int width = all.x2 - all.x1, height = all.y2 - all.y1;
  std::printf("%s: %d x %d pixels, the dot at %s\n", what.c_str(), width, height, told(found).c_str());
}

/// What the overlay does with the pen.
static void drags(Effect &effect) {
  effect.getOverlayDescriptor();
  Overlay overlay(effect);
  check(overlay.createInstanceAction() == kOfxStatOK, "overlay: create instance");
  std::vector<string> slaves;
  overlay.getSlaveToParam(slaves);
  check(slaves.size() == 98, "overlay: " + std::to_string(slaves.size()) + " parameters that it depends on");
  check(overlay.drawAction(1, effect.scales()) != kOfxStatFailed, "overlay: draw");
  const OfxPointI view = {0, 0};
  const OfxPointD from = {TARGET.first, TARGET.second}, to = {TARGET.first + 10, TARGET.second - 5}, off = {3, 3};
  check(overlay.penDownAction(1, effect.scales(), from, view, 1) == kOfxStatOK, "overlay: the pen hits the target");
  check(effect.edits == 1, "overlay: a drag is one step to undo");
  check(overlay.penMotionAction(1, effect.scales(), to, view, 1) == kOfxStatOK, "overlay: drag");
  check(overlay.penUpAction(1, effect.scales(), to, view, 1) == kOfxStatOK, "overlay: release");
  check(effect.edits == 0 && effect.redraws > 0, "overlay: the step is over, and drawn");
  const Point moved = effect.param<Double2D>("pin1Target").at(0);
  check(near(moved, Point(to.x, to.y), 1e-9), "overlay: the target follows the pen");
  char none[] = "";
  const int escape = 0xFF1B;
  const OfxStatus unused[] = {overlay.penMotionAction(1, effect.scales(), off, view, 1),
                              overlay.keyDownAction(1, effect.scales(), escape, none),
                              overlay.loseFocusAction(1, effect.scales())};
  for (OfxStatus status : unused) check(status == kOfxStatReplyDefault, "overlay: what it does not use is the host's");
  effect.param<Double2D>("pin1Target").set(TARGET.first, TARGET.second);
}

/// What the buttons write and read.
static void buttons(Effect &effect, const string &folder) {
  const string shot = folder + "/written.toml";
  effect.param<Text>("writePath").set(shot.c_str());
  effect.param<Double2D>("pin1Target").set(1, TARGET.first, TARGET.second);
  effect.param<Double2D>("pin1Target").set(3, PIN.first, PIN.second);
  check(effect.edited("writeShot") == kOfxStatOK, "write a shot");
  effect.param<Text>("stmapPath").set((folder + "/stmap.####.exr").c_str());
  check(effect.edited("writeStmaps") == kOfxStatOK, "write STMaps");
  effect.param<Text>("shotFile").set(shot.c_str());
  check(effect.edited("readShot") == kOfxStatOK, "read a shot");
  check(effect.param<Double2D>("pin1Target").keys.size() == 3, "a key on every frame");
  for (const string &line : effect.said) std::printf("  %s\n", line.c_str());
  check(effect.edits == 0, "reading ends the step to undo");
}

/// PinWarp from its first instance to its last, in one context.
static void whole(ImageEffect::PluginCache &cache, const char *context, const string &folder) {
  std::unique_ptr<Effect> effect = made(cache, "io.github.pinwarp.PinWarp", context);
  check(effect->is_identity(), "nothing moves: identity");
  place_pin(*effect);
  check(!effect->is_identity(), "a pin moves: no identity");
  check(effect->getOutputPreMultiplication() == kOfxImagePreMultiplied, "premultiplication is that of the source");
  check(!effect->isFrameVarying(), "a frame does not vary");
  renders(*effect, "full size");
  scale = 0.5;
  renders(*effect, "half size");
  scale = 1;
  aspect = 2;
  renders(*effect, "pixel aspect 2");
  aspect = 1;
  effect->param<Bool>("holdBorder").set(false);
  renders(*effect, "free border");
  effect->param<Choice>("shape").set(1);
  check(effect->edited("shape") == kOfxStatOK, "shape from alpha");
  check(effect->areClipPrefsDirty() && effect->getClipPreferences(), "clip preferences follow the shape");
  renders(*effect, "shape from alpha");
  effect->param<Choice>("shape").set(0);
  const OfxRectD endless = {kOfxFlagInfiniteMin, kOfxFlagInfiniteMin, kOfxFlagInfiniteMax, kOfxFlagInfiniteMax};
  source_rod = endless;
  const OfxRectD region = effect->region();
  const bool is_endless = region.x1 <= kOfxFlagInfiniteMin && region.y2 >= kOfxFlagInfiniteMax;
  check(is_endless, "the region of an endless source is endless, not " + told(Point(region.x1, region.y2)));
  const OfxRectI window = {0, 0, WIDTH, HEIGHT};
  Picture &seen = *effect->clip("Output").fresh(window);
  check(effect->render(window) == kOfxStatOK && near(seen.brightest(), TARGET, 1), "render of an endless source");
  source_rod = {0, 0, WIDTH, HEIGHT};
  effect->purgeCachesAction();
  effect->syncPrivateDataAction();
  effect->beginInstanceEditAction();
  drags(*effect);
  effect->endInstanceEditAction();
  buttons(*effect, folder);
  for (const string &line : effect->said) check(line.find("Error") == string::npos, line);
}

/// PinWarp ST.
static void map(ImageEffect::PluginCache &cache) {
  std::unique_ptr<Effect> effect = made(cache, "io.github.pinwarp.PinWarpST", kOfxImageEffectContextFilter);
  check(effect->getOutputPreMultiplication() == kOfxImageUnPreMultiplied, "a map is not multiplied");
  check(!effect->is_identity(), "a map is not the source");
  place_pin(*effect);
  const OfxRectI window = {0, 0, WIDTH, HEIGHT};
  Picture &output = *effect->clip("Output").fresh(window);
  check(effect->render(window) == kOfxStatOK, "a map");
  const float *at = output.at(int(TARGET.first), int(TARGET.second));
  const Point origin((at[0] * WIDTH), at[1] * HEIGHT);
  check(near(origin, PIN, 1), "the map leads to " + told(origin));
}

int main(int count, char **words) {
  const string folder = count > 1 ? words[1] : ".";
  Program host(true);
  ImageEffect::PluginCache cache(host);
  PluginCache::getPluginCache()->setCacheVersion("check");
  cache.registerInCache(*PluginCache::getPluginCache());
  PluginCache::getPluginCache()->scanPluginFiles();
  whole(cache, kOfxImageEffectContextFilter, folder);
  whole(cache, kOfxImageEffectContextGeneral, folder);
  map(cache);
  PluginCache::clearPluginCache();
  std::printf(faults ? "%d faults\n" : "all well\n", faults);
  return faults ? 1 : 0;
}
