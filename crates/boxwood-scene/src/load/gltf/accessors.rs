//! Accessors: typed arrays inside the buffers.
//!
//! *How it works.* [`File::accessor`] checks once that every element lies inside its view and that sparse indices
//! rise; afterwards any element can be read, in any order, without copying the array. Integers become floats by the
//! specification's rules, so that quantised meshes need nothing else.
//!
//! *Source.* glTF 2.0, section 3.6.2, *Accessors*; `KHR_mesh_quantization`.

use super::file::File;
use super::schema::{ElementKind, Index};
use crate::SceneError;

/// What kind of number an element is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of_code(code: u32) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }
    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }
    /// The number at the start of `bytes`, which are enough.
    fn read(self, bytes: &[u8]) -> f64 {
        match self {
            Self::I8 => f64::from(bytes[0] as i8),
            Self::U8 => f64::from(bytes[0]),
            Self::I16 => f64::from(i16::from_le_bytes([bytes[0], bytes[1]])),
            Self::U16 => f64::from(u16::from_le_bytes([bytes[0], bytes[1]])),
            Self::U32 => f64::from(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
            Self::F32 => f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
        }
    }
    /// The largest value of an integer, which stands for 1 where the accessor is normalised.
    fn largest(self) -> f64 {
        match self {
            Self::I8 => 127.0,
            Self::U8 => 255.0,
            Self::I16 => 32_767.0,
            Self::U16 => 65_535.0,
            Self::U32 => 4_294_967_295.0,
            Self::F32 => 1.0,
        }
    }
}

/// A checked accessor.
#[derive(Debug)]
pub struct Accessor<'f> {
    /// Its number in the file.
    pub number: u32,
    pub count: usize,
    pub kind: ElementKind,
    pub component: Component,
    pub normalized: bool,
    dense: Option<Dense<'f>>,
    sparse: Option<Sparse<'f>>,
}

#[derive(Debug)]
struct Dense<'f> {
    bytes: &'f [u8],
    stride: usize,
}

#[derive(Debug)]
struct Sparse<'f> {
    indices: Dense<'f>,
    kind: Component,
    values: Dense<'f>,
    count: usize,
}

impl Sparse<'_> {
    fn index(&self, n: usize) -> u64 {
        self.kind
            .read(&self.indices.bytes[n * self.indices.stride..]) as u64
    }
    /// The bytes that stand for element `index`, when it is one of the exceptions.
    fn find(&self, index: usize) -> Option<&[u8]> {
        let (mut low, mut high) = (0, self.count);
        while low < high {
            let middle = low + (high - low) / 2;
            match self.index(middle).cmp(&(index as u64)) {
                std::cmp::Ordering::Less => low = middle + 1,
                std::cmp::Ordering::Greater => high = middle,
                std::cmp::Ordering::Equal => {
                    return Some(&self.values.bytes[middle * self.values.stride..]);
                }
            }
        }
        None
    }
}

impl Accessor<'_> {
    /// The bytes of an element; `None` stands for zeros.
    fn element(&self, index: usize) -> Option<&[u8]> {
        let exception = self.sparse.as_ref().and_then(|sparse| sparse.find(index));
        exception.or_else(|| {
            let dense = self.dense.as_ref()?;
            Some(&dense.bytes[index * dense.stride..])
        })
    }

    /// Element `index` as numbers. The accessor's kind has at least `N` lanes, and `index < count`.
    pub fn numbers<const N: usize>(&self, index: usize) -> [f64; N] {
        let mut lanes = [0.0; N];
        if let Some(bytes) = self.element(index) {
            for (lane, bytes) in lanes
                .iter_mut()
                .zip(bytes.chunks_exact(self.component.size()))
            {
                *lane = self.component.read(bytes);
                if self.normalized {
                    *lane = (*lane / self.component.largest()).max(-1.0);
                }
            }
        }
        lanes
    }

    /// Element `index` rounded to single precision.
    pub fn floats<const N: usize>(&self, index: usize) -> [f32; N] {
        self.numbers::<N>(index).map(|lane| lane as f32)
    }

    /// Element `index` of whole numbers.
    pub fn indices<const N: usize>(&self, index: usize) -> [u32; N] {
        self.numbers::<N>(index).map(|lane| lane as u32)
    }
}

impl<'a> File<'a> {
    /// Looks an accessor up and checks it. `path` is who asks; `kinds` is what it may be.
    pub fn accessor(
        &self,
        index: Index,
        kinds: &[ElementKind],
        path: impl FnOnce() -> String,
    ) -> Result<Accessor<'_>, SceneError> {
        let number = index.0;
        let accessor = self.at(&self.root.accessors, index, "accessor", path)?;
        let place = |key: &str| format!("accessors[{number}].{key}");
        let component = Component::of_code(accessor.component_type.0).ok_or_else(|| {
            let problem = format!(
                "{} is no type of number; 5120, 5121, 5122, 5123, 5125 or 5126 expected",
                accessor.component_type.0
            );
            self.malformed(place("componentType"), problem)
        })?;
        if !kinds.contains(&accessor.kind) {
            let names: Vec<_> = kinds.iter().map(|kind| kind.name()).collect();
            let problem = format!(
                "{} expected, but it is {}",
                names.join(" or "),
                accessor.kind.name()
            );
            return Err(self.malformed(place("type"), problem));
        }
        let count = u32::try_from(accessor.count.0).map_err(|_| {
            let problem = format!(
                "{} elements are more than can be numbered",
                accessor.count.0
            );
            self.malformed(place("count"), problem)
        })? as usize;

        // Columns of matrices begin at multiples of four bytes, but only matrices of floats are ever asked for.
        let size = component.size() * accessor.kind.lanes();
        let dense = match accessor.buffer_view {
            None => None,
            Some(view) => {
                let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
                let stride = self.root.buffer_views.get(view.0 as usize);
                let stride = stride.and_then(|view| view.byte_stride);
                let stride = stride.map_or(size, |stride| stride.0 as usize);
                Some(self.array(view, offset, stride, size, count, "", number)?)
            }
        };
        let sparse = match &accessor.sparse {
            None => None,
            Some(said) => Some(self.sparse(said, size, count, number)?),
        };
        Ok(Accessor {
            number,
            count,
            kind: accessor.kind,
            component,
            normalized: accessor.normalized && component != Component::F32,
            dense,
            sparse,
        })
    }

    /// An accessor of whole numbers.
    pub fn whole_accessor(
        &self,
        index: Index,
        kind: ElementKind,
        components: &[Component],
        path: impl FnOnce() -> String,
    ) -> Result<Accessor<'_>, SceneError> {
        let mut accessor = self.accessor(index, &[kind], path)?;
        if !components.contains(&accessor.component) {
            let path = format!("accessors[{}].componentType", index.0);
            let problem = "whole numbers without sign expected here: 5121, 5123 or 5125";
            return Err(self.malformed(path, problem));
        }
        accessor.normalized = false;
        Ok(accessor)
    }

    #[expect(clippy::too_many_arguments, reason = "all of it describes one array")]
    fn array(
        &self,
        view: Index,
        offset: u64,
        stride: usize,
        size: usize,
        count: usize,
        within: &str,
        number: u32,
    ) -> Result<Dense<'_>, SceneError> {
        let place = |key: &str| format!("accessors[{number}].{within}{key}");
        let (_, bytes) = self.view(view, || place("bufferView"))?;
        if stride < size {
            let problem = format!(
                "{stride} is less than the {size} bytes of one element of accessors[{number}]"
            );
            return Err(self.malformed(format!("bufferViews[{}].byteStride", view.0), problem));
        }
        // At most 2³² elements, each at most 2³² bytes apart: no overflow.
        let span = match count {
            0 => 0,
            _ => (count as u64 - 1) * stride as u64 + size as u64,
        };
        if offset.saturating_add(span) > bytes.len() as u64 {
            let problem = format!(
                "{count} elements need {span} bytes from byte {offset} on, but bufferViews[{}] has {} bytes",
                view.0,
                bytes.len()
            );
            return Err(self.malformed(place("count"), problem));
        }
        Ok(Dense {
            bytes: &bytes[offset as usize..],
            stride,
        })
    }

    fn sparse(
        &self,
        said: &super::schema::Sparse,
        size: usize,
        elements: usize,
        number: u32,
    ) -> Result<Sparse<'_>, SceneError> {
        let place = |key: &str| format!("accessors[{number}].sparse.{key}");
        let kind = match Component::of_code(said.indices.component_type.0) {
            Some(kind @ (Component::U8 | Component::U16 | Component::U32)) => kind,
            _ => {
                let problem = "5121, 5123 or 5125 expected";
                return Err(self.malformed(place("indices.componentType"), problem));
            }
        };
        if said.count.0 > elements as u64 {
            let problem = format!("{} exceptions from {elements} elements", said.count.0);
            return Err(self.malformed(place("count"), problem));
        }
        let count = said.count.0 as usize;
        let offset =
            |offset: Option<super::schema::Whole<u64>>| offset.map_or(0, |offset| offset.0);
        let sparse = Sparse {
            indices: self.array(
                said.indices.buffer_view,
                offset(said.indices.byte_offset),
                kind.size(),
                kind.size(),
                count,
                "sparse.",
                number,
            )?,
            kind,
            values: self.array(
                said.values.buffer_view,
                offset(said.values.byte_offset),
                size,
                size,
                count,
                "sparse.",
                number,
            )?,
            count,
        };
        // Looking through the exceptions takes time, once for everybody who shares the accessor.
        self.spend(count as u64, || place("count"))?;
        let mut next = 0;
        for n in 0..count {
            let index = sparse.index(n);
            if index < next || index >= elements as u64 {
                let problem = format!(
                    "entry {n} is {index}, but the entries must rise and be less than {elements}"
                );
                return Err(self.malformed(place("indices"), problem));
            }
            next = index + 1;
        }
        Ok(sparse)
    }
}
