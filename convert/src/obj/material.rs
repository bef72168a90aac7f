//! From MTL materials to AAM's.

use aam::document::{Displacement, Flagged, Layer, NormalSpace, SingleMaterial, Texture};

use crate::Report;
use crate::authoring::DEFAULT_TESSELLATION;
use crate::phong::{MetallicRoughness, decode_srgb, from_metallic_roughness, shininess};

use super::mtl::{Map, Mtl, Slot};
use super::textures::{Picture, Textures, named};

/// What an MTL material becomes.
pub(super) struct Material {
    pub(super) single: SingleMaterial,
    /// For the objects that use it, since AAM keeps these with objects.
    pub(super) displacement: Option<Displacement>,
}

/// Diffuse reflectance of a material without `Kd` and `map_Kd`.
const DEFAULT_DIFFUSE: f32 = 0.8;

/// Converts a material; what it cannot keep goes into the report.
pub(super) fn convert(mtl: &Mtl, textures: &mut Textures, report: &mut Report) -> Material {
    let mut conversion = Conversion { mtl, subject: mtl.subject(), textures, report };
    let mut single = conversion.colors();
    single.class = "Standard".into();
    single.transparency = 1.0 - mtl.opacity.unwrap_or(1.0);
    conversion.diffuse_texture(&mut single);
    conversion.normal_texture(&mut single);
    let displacement = conversion.displacement(&mut single);
    conversion.what_is_lost(&single);
    Material { single, displacement }
}

struct Conversion<'a> {
    mtl: &'a Mtl,
    subject: String,
    textures: &'a mut Textures,
    report: &'a mut Report,
}

impl Conversion<'_> {
    fn colors(&mut self) -> SingleMaterial {
        let mtl = self.mtl;
        let default = if mtl.maps.contains_key(&Slot::Diffuse) { 1.0 } else { DEFAULT_DIFFUSE };
        let diffuse = mtl.diffuse.unwrap_or([default; 3]);
        let emission = mtl.emission.filter(|emission| *emission != [0.0; 3]);
        let physical = [Slot::Roughness, Slot::Metallic].iter().any(|slot| mtl.maps.contains_key(slot));
        if mtl.roughness.is_some() || mtl.metallic.is_some() || physical {
            return self.physical(diffuse, emission);
        }
        let mut single = SingleMaterial {
            // Without a `Ka` of its own, a material shows its colour in ambient light too.
            ambient: mtl.ambient.unwrap_or(diffuse),
            diffuse,
            emission,
            ..SingleMaterial::default()
        };
        match mtl.model {
            Some(0) => {
                // "Color on and Ambient off": the colour as it is, whatever the light.
                single.emission = Some(diffuse);
                single.ambient = [0.0; 3];
                single.diffuse = [0.0; 3];
            }
            // No highlight.
            Some(1) => {}
            model => {
                single.specular = mtl.specular.unwrap_or([0.0; 3]);
                let exponent = mtl.exponent.unwrap_or(0.0);
                single.shininess = shininess(exponent);
                if exponent == 0.0 && single.specular != [0.0; 3] {
                    let note = "Ns 0 is no highlight here, not one that covers everything";
                    self.report.changed(&self.subject, "highlight", note, None);
                }
                if let Some(model @ 3..) = model {
                    let note = format!("illum {model} becomes 2: there are no reflected or refracted rays");
                    self.report.changed(&self.subject, "illumination model", note, None);
                }
            }
        }
        single
    }

    /// Roughness and metallic factors, where a texture gives them by its mean.
    fn physical(&mut self, diffuse: [f32; 3], emission: Option<[f32; 3]>) -> SingleMaterial {
        let mut factor = |slot: Slot, value: Option<f32>, default: f32| {
            let Some(map) = self.mtl.maps.get(&slot) else { return value.unwrap_or(default) };
            let found = self.textures.find(&map.file);
            match found.and_then(|picture| self.textures.mean(&picture)) {
                Ok(mean) => {
                    let note = "the texture becomes its mean: Phong has no such texture";
                    self.report.changed(&self.subject, slot.word(), note, Some(format!("mean {mean:.3}")));
                    mean * value.unwrap_or(1.0)
                }
                Err(reason) => {
                    self.report.lost(&self.subject, slot.word(), format!("{}: {reason}", map.file));
                    value.unwrap_or(default)
                }
            }
        };
        let material = MetallicRoughness {
            metallic: factor(Slot::Metallic, self.mtl.metallic, 0.0),
            roughness: factor(Slot::Roughness, self.mtl.roughness, 0.5),
            base_color: diffuse.map(decode_srgb),
            ..MetallicRoughness::default()
        };
        let phong = from_metallic_roughness(&material);
        self.report.changed(&self.subject, "roughness and metallic", "Pr and Pm become a Phong highlight", None);
        SingleMaterial {
            ambient: phong.ambient,
            diffuse: phong.diffuse,
            specular: phong.specular,
            shininess: shininess(phong.exponent),
            emission,
            ..SingleMaterial::default()
        }
    }

    fn find(&mut self, map: &Map, slot: Slot) -> Picture {
        named(self.textures, &map.file, &self.subject, slot.word(), self.report)
    }

    /// `map_Kd`, with the alpha of `map_d`.
    fn diffuse_texture(&mut self, single: &mut SingleMaterial) {
        let maps = &self.mtl.maps;
        let emission_alone = |map: &&Map| single.diffuse == [0.0; 3] && !map.file.is_empty();
        let (map, slot) = match (maps.get(&Slot::Diffuse), maps.get(&Slot::Emission).filter(emission_alone)) {
            (Some(map), _) => (map, Slot::Diffuse),
            // The texture multiplies emission too, so where nothing else is lit it can be the emission's.
            (None, Some(map)) => (map, Slot::Emission),
            (None, None) => match maps.get(&Slot::Opacity) {
                Some(map) => {
                    let note = format!("{}: an opacity texture needs a diffuse texture to go with", map.file);
                    return self.report.lost(&self.subject, "map_d", note);
                }
                None => return,
            },
        };
        let picture = self.find(map, slot);
        let mut name = None;
        if let Some(opacity) = maps.get(&Slot::Opacity) {
            let alpha = self.find(opacity, Slot::Opacity);
            let same_place = opacity.offset == map.offset && opacity.scale == map.scale;
            if alpha.name == picture.name {
                self.report.kept(&self.subject, "map_d", "the alpha of the diffuse texture");
            } else if !same_place {
                let note = "its -o and -s differ from those of map_Kd, and there is one set for both";
                self.report.lost(&self.subject, "map_d", note);
            } else {
                match self.textures.with_alpha(&picture, &alpha, opacity.channel) {
                    Ok(made) => {
                        let note = format!("{} and {} become {made}", picture.name, alpha.name);
                        self.report.changed(&self.subject, "map_d", note, None);
                        name = Some(made);
                    }
                    Err(reason) => self.report.lost(&self.subject, "map_d", format!("{}: {reason}", opacity.file)),
                }
            }
        }
        let name = name.unwrap_or_else(|| self.textures.add(&picture));
        single.layers[Layer::Diffuse as usize] = Flagged::Yes(Box::new(self.texture(map, slot, name)));
    }

    /// `norm`, else `bump`.
    fn normal_texture(&mut self, single: &mut SingleMaterial) {
        let maps = &self.mtl.maps;
        let texture = match (maps.get(&Slot::Normal), maps.get(&Slot::Bump)) {
            (Some(map), bump) => {
                if let Some(bump) = bump.filter(|bump| bump.file != map.file) {
                    let note = format!("{}: there is a normal map (norm) as well, which is used", bump.file);
                    self.report.lost(&self.subject, "bump", note);
                }
                let picture = self.find(map, Slot::Normal);
                let name = self.textures.add(&picture);
                Texture { intensity: map.bump, ..self.texture(map, Slot::Normal, name) }
            }
            (None, Some(map)) => {
                let picture = self.find(map, Slot::Bump);
                match self.textures.normals(&picture, map.bump) {
                    Ok(Some(name)) => {
                        let note = format!("the heights of {} become the normals of {name}", picture.name);
                        self.report.changed(&self.subject, "bump", note, None);
                        self.texture(map, Slot::Bump, name)
                    }
                    Ok(None) => {
                        let note = format!("{} holds normals, not heights, and is used as a normal map", picture.name);
                        self.report.changed(&self.subject, "bump", note, None);
                        let name = self.textures.add(&picture);
                        Texture { intensity: map.bump, ..self.texture(map, Slot::Bump, name) }
                    }
                    Err(reason) => {
                        return self.report.lost(&self.subject, "bump", format!("{}: {reason}", map.file));
                    }
                }
            }
            (None, None) => return,
        };
        single.layers[Layer::Normal as usize] =
            Flagged::Yes(Box::new(Texture { normal_space: Some(NormalSpace::Tangent), ..texture }));
    }

    fn displacement(&mut self, single: &mut SingleMaterial) -> Option<Displacement> {
        let map = self.mtl.maps.get(&Slot::Displacement)?;
        let picture = self.find(map, Slot::Displacement);
        let name = self.textures.add(&picture);
        single.layers[Layer::Displacement as usize] =
            Flagged::Yes(Box::new(self.texture(map, Slot::Displacement, name)));
        // With -bm as an older way to say the same as the gain.
        let scale = (map.gain * map.bump).clamp(f32::MIN, f32::MAX);
        Some(Displacement { tessellation: DEFAULT_TESSELLATION, bias: map.base, scale })
    }

    /// A texture block with the transform of a map.
    fn texture(&mut self, map: &Map, slot: Slot, name: String) -> Texture {
        let mut texture = Texture::new(name);
        // OBJ: uv·s + o. AAM, about the middle: ½ + s·(uv − ½ − offset).
        let tiling = map.scale.map(|scale| scale as f32);
        let offset: [f32; 2] = std::array::from_fn(|i| ((0.5 - map.offset[i]) / map.scale[i] - 0.5) as f32 + 0.0);
        if tiling.contains(&0.0) {
            self.report.lost(&self.subject, slot.word(), "-s 0 would spread one texel over everything; it is left out");
        } else if tiling.iter().chain(&offset).any(|value| !value.is_finite()) {
            self.report.lost(&self.subject, slot.word(), "-s and -o are beyond 32-bit numbers; they are left out");
        } else {
            (texture.tiling, texture.offset) = (tiling, offset);
        }
        if map.clamp {
            self.report.changed(&self.subject, slot.word(), "-clamp on is left out: textures repeat", None);
        }
        for option in &map.unused {
            self.report.lost(&self.subject, slot.word(), format!("the option {option} is left out"));
        }
        texture
    }

    fn what_is_lost(&mut self, single: &SingleMaterial) {
        for (slot, map) in &self.mtl.maps {
            let reason = match slot {
                Slot::Ambient if self.mtl.maps.get(&Slot::Diffuse).is_some_and(|diffuse| diffuse.file == map.file) => {
                    // The diffuse texture multiplies ambient light as well.
                    continue;
                }
                Slot::Ambient => "the diffuse texture multiplies ambient light; there is no other",
                Slot::Specular => "there is no texture for the highlight's colour",
                Slot::Exponent => "there is no texture for the exponent",
                Slot::Reflection => "there are no reflections",
                Slot::Decal => "there are no decals",
                Slot::Emission => {
                    let used = single.layers[Layer::Diffuse as usize].as_ref().is_some()
                        && !self.mtl.maps.contains_key(&Slot::Diffuse);
                    if used {
                        continue;
                    }
                    "there is no texture for emission"
                }
                Slot::Diffuse
                | Slot::Opacity
                | Slot::Normal
                | Slot::Bump
                | Slot::Displacement
                | Slot::Roughness
                | Slot::Metallic => continue,
            };
            self.report.lost(&self.subject, slot.word(), format!("{}: {reason}", map.file));
        }
        for (statement, reason) in &self.mtl.lost {
            self.report.lost(&self.subject, statement, *reason);
        }
    }
}
