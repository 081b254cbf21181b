import sys; sys.path.insert(0,'/work/main')
import time, random
from fractions import Fraction as Fr
from collections import Counter
import numpy as np
from cdpr_interval import load_robot
import solvers.six_dof as sd, solvers.platform_subset as ps
from solvers import forward_kinematics
from tests.platform_cells import Stepper, turn
from certificates.polynomials import *
from certificates.geometry import *
from certificates import cells as cl, guess
name,ls=sys.argv[1],sys.argv[2].split(',')
keep=[]
orig=ps.SubsetSearch
class Sub(orig):
    def solve(self): super().solve(); keep.append(self)
sd.SubsetSearch=Sub
r=load_robot(name); res=forward_kinematics(r,ls,taut=range(len(ls)))
sub=keep[0]; m=sub.model; n=m.n_taut
from solvers.problem import Problem
pr=Problem(r,())
order=[int(x) for x in m.orders[0]]
A=[r.cables[i].frame_anchor for i in order]; B=[pr.anchors_from_centre[i] for i in order]
cst=lambda v:[constant(rational(x)) for x in v]
pf=Platform([cst(a) for a in A],[cst(b) for b in B],[constant(rational(Fr(ls[i])**2)) for i in order],cst(pr.load),n,rational(m.size))
st=Stepper(turn,m,roots=None,leaf_size=0.01)
rows=ps.root_rows(m,sub.roots)
st.context=(m,rows,0.01,*st.context[3:])
stack=[c for c in ps.start_cells(sub.reduction)]
ex=[];N=0;cnt=Counter()
rng=random.Random(3)
while stack:
    c=stack.pop(); v,ch=st.step([c])[0]; N+=1
    if v==0: ex.append(c)
    elif v>0: stack+= [x.copy() for x in ch]
print(N,len(ex))
K=int(sys.argv[3]); tt=0
for c in rng.sample(ex,K):
    t=time.perf_counter()
    out=[]
    u=[between(rational(c[2*k]),rational(c[2*k+1]),k) for k in range(3)]
    T=Turned(pf,int(c[6]),u)
    for br in ((1,-1) if c[7]==0 else (int(c[7]),)):
        x=cl.on_branch(T,br)
        if x is None:
            out.append('empty' if cl.no_position(T) else 'noplace'); continue
        P=cl.Place(T,x)
        w=T.wrenches(x)
        rows_=[[cl.number(centre(v)) for v in q] for q in w]
        nr=[guess.inner(a,a)**.5 for a in rows_]
        ext=[]
        for j in range(3,n):
            f=P.freed(P.equations[j]); 
            if lowest(f)>0 or highest(f)<0: ext.append(j)
        if ext: out.append('length'); continue
        y=guess.least_norm([[v/q for v in a] for a,q in zip(rows_,nr)],[[1.0]*(n+1)])[0]
        out.append(P.unbalanced([rational(v) for v in y]))
    tt+=time.perf_counter()-t
    cnt[tuple(out)]+=1
print(cnt, tt/K*1e3,'ms')
